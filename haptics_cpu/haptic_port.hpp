#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// What the haptic thread is plugged into: where goals come from and forces go. Called every millisecond from
/// that thread alone; must not wait. One that throws has failed.
class HapticPort {
public:
    virtual ~HapticPort() = default;
    /// Goals of a tick, world, scene units, one per finger. False: the device is gone, and the loop ends.
    virtual bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) = 0;
    /// Called before the goals of a tick that comes after a gap of so many ms without ticks (longer than
    /// HapticLoop::longest_gap_ns). The hand may be anywhere by then, and another person's.
    virtual void come_back(std::int64_t) {}
    /// Guarded forces, newtons, world axes. False as above. The last call of a loop, however it ends, writes
    /// zeros.
    virtual bool write_forces(std::span<const glm::dvec3> newtons) = 0;
    /// Of what was written last, how much of a finger's force went to the hand: 0 to 1.
    virtual double share(std::size_t) const { return 1; }
};

}  // namespace touchable
