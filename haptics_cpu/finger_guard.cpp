#include "haptics_cpu/finger_guard.hpp"

namespace touchable {

GuardedForce FingerGuard::guard(const Contact& contact) {
    const CalmedForce calmed = jump_.calm(contact);
    GuardedForce out = calmed.active ? guard_.guard_calmed(contact, calmed) : guard_.guard(contact);
    if ((out.reasons & guard_fault) && guard_.has_begun_anew()) jump_.reset();
    if (calmed.waiting) out.reasons |= guard_waiting;
    return out;
}

void FingerGuard::surface_is_new() {
    if (has_let_go()) jump_.reset();  // the hand gets nothing that could fade
    jump_.surface_is_new();
}

}  // namespace touchable
