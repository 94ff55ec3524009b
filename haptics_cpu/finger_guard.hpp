#pragma once

#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/jump_cancellation.hpp"

namespace touchable {

/// All that stands between what a finger met and its device: jump cancellation, then the force guard.
/// Whatever comes in, what goes out is finite and no longer than the device's force.
class FingerGuard {
public:
    FingerGuard(const GuardSettings& settings, double metres_per_scene_unit)
        : jump_(settings), guard_(settings, metres_per_scene_unit) {}

    /// `surface_share`: how much of the surface is felt at all (StaleSurface).
    GuardedForce guard(const Contact& contact, double surface_share = 1);
    /// The next contact is with a surface that is new to the finger.
    void surface_is_new();
    /// Goals have been missing for so long that no force is left.
    bool has_let_go() const { return guard_.has_let_go(); }
    /// ForceGuard::let_go.
    void let_go() { guard_.let_go(); }

private:
    JumpCancellation jump_;
    ForceGuard guard_;
};

}  // namespace touchable
