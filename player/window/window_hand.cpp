#include "player/window/window_hand.hpp"

#include "player/window/command_table.hpp"
#include "player/window/window_core.hpp"

namespace touchable {

void WindowHand::power_off() {
    const auto& device = core_.options.hand;
    if (!device) return;
    device->power_off();
    if (core_.clip()) core_.clip()->set_force(false);
}

void WindowHand::stop_at_once(InputEvent& event) {
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (!binding || binding->verb != WindowVerb::force || event.repeated) return;
    const PlayOptions& options = core_.options;
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
    pointer_ = core_.clip()->device();
    control_ = core_.clip()->session().setup().options.control;
}

void WindowHand::look_after() {
    const PersistentDevice& device = *core_.options.hand;
    const bool gone = device.is_gone();
    if (gone == std::exchange(is_gone_, gone) || !gone) return;
    core_.time.note_event();
    if (const auto health = device.health(); !health) {
        const std::string fault = core_.options.names.error(health.error());
        core_.note_fault(fault);
        core_.tell(fault);
    }
}

void WindowHand::turn_force(bool may_turn_on) {
    OpenedClip& clip = *core_.clip();
    const bool on = may_turn_on && !clip.force_is_on();
    const auto& device = core_.options.hand;
    if (!device) {
        clip.set_force(on);
        return core_.say(clip.force_is_on() ? "force on" : "force off");
    }
    // The device comes back without forces, as its user may have left by then.
    if (device->is_gone()) {
        clip.set_force(false);
        return device->look_again();
    }
    // Forces cannot be requested while the device is away: they would return without warning.
    if (on && !(device->age_s() <= HapticDevice::oldest_s))
        return core_.say("no forces yet: no position comes from the " + device->name());
    clip.set_force(on);
}

void WindowHand::change_scale(double times) {
    const char* const name = "hand-scale";
    const auto chosen = core_.clips().wanted_settings().in_effect.now().values();
    const auto found = chosen.find(name);
    const std::string now = found != chosen.end() ? found->second : core_.clip()->in_effect().at(name);
    const SettingRange& range = session_setting(name)->range;
    const double scale = std::clamp(parsed_number(now).value_or(1) * times, range.least, range.most);
    core_.clips().feel({WindowVerb::feel, 0, name + (" " + std::to_string(scale))});
}

}  // namespace touchable
