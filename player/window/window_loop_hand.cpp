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

/// The screen's thread calls it: F takes forces off while the main thread draws or waits. F where forces are
/// off asks for them, which is the main thread's.
void WindowLoop::stop_force_at_once(InputEvent& event) {
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (!binding || binding->verb != WindowVerb::force || event.repeated) return;
    if (options_.study && !options_.hand) return;  // a participant's mouse has no such key
    const std::lock_guard lock(force_mutex_);
    if (force_givers_.control && force_givers_.control->force_is_asked()) {
        force_givers_.control->ask_force(false);
        event.stopped_force = true;
    } else if (!force_givers_.control && force_givers_.pointer && force_givers_.pointer->force_is_on()) {
        force_givers_.pointer->set_force(false);
        event.stopped_force = true;
    }
}

/// From now on stop_force_at_once stops the newest session of the clip. A key that came between that
/// session's begin and this call has stopped the session before; the main thread then stops this one, as for
/// every key.
void WindowLoop::lead_force() {
    const std::lock_guard lock(force_mutex_);
    force_givers_ = {clip_->shared_device(), clip_->session().setup().control};
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
            if (command.number == 0 && !clip_->force_is_on() && !(hand.age_s() <= HapticDevice::oldest_s))
                return say("no forces yet: no position comes from the " + hand.name());
            return clip_->set_force(command.number == 0 && !clip_->force_is_on());
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
