#include <algorithm>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "player/window/window_loop.hpp"

// A device that is held, in place of the mouse.

namespace touchable {

/// Once a turn. (That forces are off once nobody was there for a second, HandControl sees to.)
void WindowLoop::look_after_hand(const WatchedMoment* moment) {
    PersistentDevice& hand = *options_.hand;
    if (const bool gone = hand.is_gone(); gone != std::exchange(hand_is_gone_, gone) && gone) {
        last_event_ = Clock::now();
        if (const auto health = hand.health(); !health.ok()) {
            const std::string fault = options_.names.error(health.error());
            log_fault(fault);
            tell(fault);
        }
    }
    if (!kiosk_ || !moment || moment->felt.fingers.empty()) return;
    const glm::dvec3 goal = moment->felt.fingers[0].goal, way = goal - hand_seen_at_;
    const double far = clip_->sizes().finger_radius / 2;
    if (glm::dot(way, way) < far * far || !(glm::dot(goal, goal) >= 0)) return;
    hand_seen_at_ = goal;
    // Another clip, or one that has begun anew, maps a hand that rests to another place of its world.
    constexpr double mapped_s = 0.5;
    if (now_s() > begun_anew_s_ + mapped_s) kiosk_->came(now_s());
}

/// Nobody sees any more what is asked for. It is asked for no longer, too, so that what is recorded of the
/// session's last ticks is what the hand had.
void WindowLoop::power_hand_off() {
    if (!options_.hand) return;
    options_.hand->power_off();
    if (clip_) clip_->set_force(false);
}

void WindowLoop::take_of_hand(const WindowCommand& command) {
    PersistentDevice& hand = *options_.hand;
    switch (command.verb) {
        case WindowVerb::force:
            // It comes back without forces: nobody may be there by then.
            if (hand.is_gone()) {
                clip_->set_force(false);
                return hand.look_again();
            }
            // Of one that is away forces are not asked for: nobody would know of them when it comes back.
            if (!clip_->force_is_on() && !(hand.age_s() <= HapticDevice::oldest_s))
                return say("no forces yet: no position comes from the " + hand.name());
            return clip_->set_force(!clip_->force_is_on());
        case WindowVerb::clutch:
            return clip_->control()->hold(command.number != 0);
        case WindowVerb::recentre:
            clip_->control()->recentre();
            return say("the middle is where the hand is");
        case WindowVerb::coarser:
            return change_scale(command.number);
        default:
            return say("the fingers are those of the " + hand.name());
    }
}

/// A setting like the others, by steps.
void WindowLoop::change_scale(double times) {
    const char* const name = "hand-scale";
    const auto chosen = wanted_settings_.value_or(settings_).in_effect.now().values();
    const auto found = chosen.find(name);
    const std::string now = found != chosen.end() ? found->second : clip_->in_effect().at(name);
    const SessionSetting& setting = *session_setting(name);
    const double scale = std::clamp(number_of(now).value_or(1) * times, setting.least, setting.most);
    feel({WindowVerb::feel, 0, name + (" " + std::to_string(scale))});
}

}  // namespace touchable
