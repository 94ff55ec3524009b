#include "player/session/held_port.hpp"

#include <algorithm>
#include <cmath>

#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/field_probe.hpp"

namespace touchable {

// One rule for a hand that fell silent and for a program that stood still.
static_assert(HandControl::away_ticks * std::int64_t{1'000'000} +
                  static_cast<std::int64_t>(HapticDevice::oldest_s * 1e9) ==
              HapticLoop::longest_gap_ns);

HeldPort::HeldPort(HapticDevice& device, HandControl& control, DeviceTickLog* log)
    : device_(device),
      control_(control),
      log_(log),
      has_motors_(device.capabilities().axes_driven > 0),
      places_(static_cast<std::size_t>(device.fingers())),
      newtons_(static_cast<std::size_t>(device.fingers())) {}

bool HeldPort::read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) {
    tick_ = tick;
    if (!device_.read_positions(places_)) return false;
    std::copy(places_.begin(), places_.end(), goals.begin());
    const FieldProbe probe(field);
    control_.to_goals(goals, device_.buttons(), &probe);
    return true;
}

bool HeldPort::write_forces(std::span<const glm::dvec3> newtons) {
    const auto passed = static_cast<int>(std::min<std::int64_t>(tick_ - written_, HandControl::rise_ticks));
    const bool is_tick = tick_ > written_;  // the zeros at the end are of none
    written_ = tick_;
    control_.to_device(newtons, passed, newtons_);
    for (std::size_t finger = 0; finger < newtons_.size(); ++finger)
        if (!has_place(finger) && std::isfinite(newtons_[finger].x)) newtons_[finger] = glm::dvec3(0.0);
    const bool works = device_.write_forces(newtons_);
    if (log_ && is_tick)
        log_->push({tick_, device_.buttons(), device_.age_s(), control_.exerts(), places_, newtons_});
    return works;
}

/// One without has no force, which its device would not let out either.
bool HeldPort::has_place(std::size_t finger) const {
    return std::isfinite(places_[finger].x);
}

double HeldPort::share(std::size_t finger) const {
    if (!has_motors_) return 1;
    return has_place(finger) ? control_.share(finger) : 0;
}

}  // namespace touchable
