#include "player/audio/touch_listener.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {
namespace {

constexpr double seconds_per_tick = 0.001;
constexpr double creep = 1e-4;  // m/s: slower than that it is stuck
/// From a session's begin on, in which forces come back by the guard's ramp: what is new then is the surface,
/// and no finger has met it.
constexpr std::int64_t settling_ticks = 100;

}  // namespace

HeardFinger TouchListener::hear(const TouchTick& tick, std::size_t finger) {
    const Contact& contact = tick.contacts[finger];
    const glm::dvec3& force = tick.forces[finger].force;
    Before& before = before_[finger];
    const double metres = tick.metres_per_scene_unit;
    const double seconds = std::max(contact.ticks, 1) * seconds_per_tick;
    const double newtons = glm::length(force), changed = glm::length(force - before.force);
    HeardFinger heard;
    heard.touching = contact.touching;
    heard.share = static_cast<float>(tick.share(finger));
    heard.newtons = static_cast<float>(newtons);
    heard.stiffness = static_cast<float>(contact.properties.stiffness);
    heard.side = static_cast<float>(2 * contact.pixel_x / width_ - 1);
    if (contact.touching && !before.touching) {
        // As fast as the finger came, or the surface to one that rests: how deep it is after a tick.
        const glm::dvec3 depth = contact.proxy - contact.goal;
        const double length = glm::length(depth);
        const double came = length > 0 ? glm::dot(before.goal - contact.goal, depth) / length : 0;
        heard.met = static_cast<float>(metres * std::max(came, length) / seconds);
    }
    const bool stays = contact.touching && before.touching && !contact.jumped && contact.carried_stiffness;
    if (stays) {
        const glm::dvec3 slipped = contact.proxy - contact.carried;
        const double way = glm::length(slipped);
        heard.slip = static_cast<float>(metres * way / seconds);
        heard.change = static_cast<float>(changed / std::max(contact.ticks, 1));
        // Friction is along the way, and what presses is across it.
        const double along = way > 0 ? glm::dot(force, slipped) / way : 0;
        heard.newtons = static_cast<float>(std::sqrt(std::max(newtons * newtons - along * along, 0.0)));
        if (before.stuck && heard.slip > creep) heard.let_go = static_cast<float>(changed);
    }
    if (tick.tick < settling_ticks) heard.met = heard.change = heard.let_go = 0;
    before = {contact.touching, stays && heard.slip <= creep, contact.goal, force};
    return heard;
}

HeardClip TouchListener::hear_clip(std::int64_t tick) {
    const PlaybackState state = clock_->state_at(tick);
    return {state.playing && state.moment.time_ns < end_ns_, state.moment.time_ns, state.moment.epoch,
            static_cast<float>(static_cast<double>(state.rate) / 1000)};
}

Result<void> TouchListener::take(const TouchTick& tick) {
    HeardTick heard;
    const std::size_t fingers = std::min(tick.contacts.size(), heard.fingers.size());
    for (std::size_t k = 0; k < fingers; ++k) heard.fingers[k] = hear(tick, k);
    const std::int64_t passed = tick.tick - last_tick_;
    last_tick_ = tick.tick;
    if (!begun_.load(std::memory_order_acquire)) return {};
    heard.clip = hear_clip(tick.tick);
    sound_.take(heard, passed);
    return {};
}

}  // namespace touchable
