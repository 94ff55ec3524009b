#include "player/session/held_port.hpp"

#include <algorithm>

#include "player/session/field_probe.hpp"

namespace touchable {

HeldPort::HeldPort(HapticDevice& device, HandControl& control, DeviceTickLog* log)
    : device_(device),
      control_(control),
      log_(log),
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
    const bool works = device_.write_forces(newtons_);
    if (log_ && is_tick)
        log_->push({tick_, device_.buttons(), device_.age_s(), control_.exerts(), places_, newtons_});
    return works;
}

}  // namespace touchable
