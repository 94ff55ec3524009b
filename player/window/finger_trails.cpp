#include "player/window/finger_trails.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "player/run/field_probe.hpp"

namespace touchable {
namespace {

constexpr std::int64_t trail_ticks = 500;
constexpr double farthest_apart = 0.05;  // of a trail from one picture to the next, of the clip's width

/// Whether a finger is nowhere, or where it touches nothing, before the clip's camera: so near to that it
/// would be in the way of all else.
bool is_away(const WatchedFinger& finger, const FieldProbe& probe, double nearest_share) {
    if (!std::isfinite(glm::dot(finger.goal, finger.goal))) return true;
    const Contact& contact = finger.contact;
    if (contact.touching) return false;
    if (!(contact.goal.z < 0)) return true;
    const glm::dvec3 pixel = probe.project(contact.goal);
    const auto depth = probe.depth_under(pixel.x, pixel.y);
    return depth && pixel.z < *depth * nearest_share;
}

}  // namespace

std::vector<FingerMark> FingerTrails::marks(const WatchedTick& tick, int count, const HeightField& field,
                                            double nearest_share) {
    const auto shown = std::min(tick.fingers.size(), static_cast<std::size_t>(count));
    const FieldProbe probe(field);
    trails_.resize(shown);
    std::vector<FingerMark> marks;
    const double gap = farthest_apart * field.width();
    for (std::size_t k = 0; k < shown; ++k) {
        const Contact& contact = tick.fingers[k].contact;
        std::deque<Place>& trail = trails_[k];
        const bool away = is_away(tick.fingers[k], probe, nearest_share);
        if (!contact.touching || !std::isfinite(contact.pixel_x) || !std::isfinite(contact.pixel_y))
            trail.clear();
        else if (const glm::dvec2 now(contact.pixel_x, contact.pixel_y);
                 !trail.empty() && glm::distance(trail.back().pixel, now) > gap)
            trail.clear();
        else
            trail.push_back({tick.tick, {contact.pixel_x, contact.pixel_y}});
        while (!trail.empty() && trail.front().tick + trail_ticks < tick.tick) trail.pop_front();
        FingerMark mark{contact.goal, contact.proxy, tick.fingers[k].force.force, contact.touching,
                        {},           !away};
        for (const Place& place : trail)
            if (const auto depth = probe.depth_under(place.pixel.x, place.pixel.y))
                mark.trail.push_back(probe.unproject(place.pixel.x, place.pixel.y, *depth));
        marks.push_back(std::move(mark));
    }
    return marks;
}

}  // namespace touchable
