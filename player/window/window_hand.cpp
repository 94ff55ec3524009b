// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_hand.hpp"

#include "player/window/command_table.hpp"
#include "player/window/window_state.hpp"

namespace touchable {

void WindowHand::power_off() {
    const auto& device = window_.options.hand;
    if (!device) return;
    device->power_off();
    if (window_.clip) window_.clip->set_force(false);
}

void WindowHand::stop_at_once(InputEvent& event) {
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (!binding || binding->verb != WindowVerb::force || event.repeated) return;
    const PlayOptions& options = window_.options;
    if (options.study && !options.hand) return;  // a participant's mouse has no such key
    const std::lock_guard lock(mutex_);
    if (control_ && control_->force_is_asked()) {
        control_->ask_force(false);
        event.stopped_force = true;
    } else if (!control_ && pointer_ && pointer_->force_is_on()) {
        pointer_->set_force(false);
        event.stopped_force = true;
    }
}

void WindowHand::lead() {
    const std::lock_guard lock(mutex_);
    pointer_ = window_.clip->device();
    control_ = window_.clip->session().setup().options.control;
}

void WindowHand::look_after() {
    const PersistentDevice& device = *window_.options.hand;
    const bool gone = device.is_gone();
    if (gone == std::exchange(is_gone_, gone) || !gone) return;
    window_.time.note_event();
    if (const auto health = device.health(); !health) {
        const std::string fault = window_.options.names.error(health.error());
        window_.note_fault(fault);
        window_.tell(fault);
    }
}

void WindowHand::turn_force(bool may_turn_on) {
    OpenedClip& clip = *window_.clip;
    const bool on = may_turn_on && !clip.force_is_on();
    const auto& device = window_.options.hand;
    if (!device) {
        clip.set_force(on);
        return window_.say(clip.force_is_on() ? "force on" : "force off");
    }
    // The device comes back without forces, as its user may have left by then.
    if (device->is_gone()) {
        clip.set_force(false);
        return device->look_again();
    }
    // Forces cannot be requested while the device is away: they would return without warning.
    if (on && !(device->age_s() <= HapticDevice::oldest_s))
        return window_.say("no forces yet: no position comes from the " + device->name());
    clip.set_force(on);
}

}  // namespace touchable
