#include "haptics_cpu/finger_guard.hpp"

namespace touchable {

GuardedForce FingerGuard::guard(const Contact& contact, double surface_share) {
    const BlendedForce blended = jump_.calm(contact);
    GuardedForce out = blended.active ? guard_.guard_blended(contact, blended, surface_share)
                                      : guard_.guard(contact, surface_share);
    if ((out.reasons & guard_fault) && guard_.has_begun_anew()) jump_.reset();
    if (blended.waiting) out.reasons |= guard_waiting;
    return out;
}

void FingerGuard::surface_is_new() {
    if (has_let_go()) jump_.reset();  // the hand gets nothing that could fade
    jump_.surface_is_new();
}

}  // namespace touchable
