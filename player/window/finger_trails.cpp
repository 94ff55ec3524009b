#include "player/window/finger_trails.hpp"

#include <algorithm>
#include <cmath>

#include "player/session/field_probe.hpp"

namespace touchable {
namespace {

constexpr std::int64_t trail_ticks = 500;

}  // namespace

std::vector<FingerMark> FingerTrails::marks(const WatchedTick& tick, int count, const HeightField& field) {
    const auto shown = std::min(tick.fingers.size(), static_cast<std::size_t>(count));
    const FieldProbe probe(field);
    trails_.resize(shown);
    std::vector<FingerMark> marks;
    for (std::size_t k = 0; k < shown; ++k) {
        const Contact& contact = tick.fingers[k].contact;
        std::deque<Place>& trail = trails_[k];
        if (!contact.touching || !std::isfinite(contact.pixel_x) || !std::isfinite(contact.pixel_y))
            trail.clear();
        else
            trail.push_back({tick.tick, {contact.pixel_x, contact.pixel_y}});
        while (!trail.empty() && trail.front().tick + trail_ticks < tick.tick) trail.pop_front();
        FingerMark mark{contact.goal, contact.proxy, tick.fingers[k].force.force, contact.touching, {}};
        for (const Place& place : trail)
            if (const auto depth = probe.depth_under(place.pixel.x, place.pixel.y))
                mark.trail.push_back(probe.unproject(place.pixel.x, place.pixel.y, *depth));
        marks.push_back(std::move(mark));
    }
    return marks;
}

}  // namespace touchable
