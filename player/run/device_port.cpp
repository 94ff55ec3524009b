#include "player/run/device_port.hpp"

#include "player/run/field_probe.hpp"

namespace touchable {

bool HandPort::read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) {
    hand_.goals_at(tick, FieldProbe(field), goals);
    return true;
}

bool DevicePort::read_goals(std::int64_t, const HeightField&, std::span<glm::dvec3> goals) {
    if (!device_.read_positions(goals)) return false;
    for (glm::dvec3& goal : goals) goal = workspace_.to_scene(goal);
    return true;
}

SimulatedPort::SimulatedPort(Hand& hand, SimulatedDevice& device, const Workspace& workspace)
    : hand_(hand), device_(device), workspace_(workspace) {}

bool SimulatedPort::read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) {
    hand_.goals_at(tick, FieldProbe(field), goals);
    const bool first = ticks_passed_ < 0;
    for (std::size_t finger = 0; finger < goals.size(); ++finger) {
        const glm::dvec3 meant = workspace_.to_device(goals[finger]);
        if (first)
            device_.put(static_cast<int>(finger), meant);
        else
            device_.intend(static_cast<int>(finger), meant);
    }
    if (first) ticks_passed_ = tick;
    for (; ticks_passed_ < tick; ++ticks_passed_) device_.pass_tick();
    if (!device_.read_positions(goals)) return false;
    for (glm::dvec3& goal : goals) goal = workspace_.to_scene(goal);
    return true;
}

}  // namespace touchable
