// SPDX-License-Identifier: Apache-2.0
// What device/force_gate.h promises, as claims about any arguments: each is checked by itself, with CLAIM its
// number, by prove.sh. A double here is any value that a double can have, NaN and infinities among them, and
// claims are comparisons of C, which are false where one side is not a number.
#include "force_gate.h"

double newtons[3];

void claim(double x, double y, double z, double ceiling, double limit, double ramp) {
    newtons[0] = x;
    newtons[1] = y;
    newtons[2] = z;
    const double most = force_gate(newtons, ceiling, limit, ramp);
    const double fx = newtons[0], fy = newtons[1], fz = newtons[2];
#if CLAIM == 1  // The ceiling is a force, and finite.
    const int holds = 0 <= most && most <= 1e9;
#elif CLAIM == 2  // It is within the limit.
    const int holds = most == 0 || most <= limit;
#elif CLAIM == 3  // It rises by the ramp at most.
    const int holds = most == 0 || most <= ceiling + ramp;
#elif CLAIM == 4  // Each component is within the ceiling. (0 is, by claim 1.)
    const int holds = fx == 0 || (fx <= most && -fx <= most);
#elif CLAIM == 5
    const int holds = fy == 0 || (fy <= most && -fy <= most);
#elif CLAIM == 6
    const int holds = fz == 0 || (fz <= most && -fz <= most);
#elif CLAIM == 7  // So is the length, by its square as computed.
    const int holds = (fx == 0 && fy == 0 && fz == 0) || fx * fx + fy * fy + fz * fz <= most * most;
#elif CLAIM == 8  // A force within the ceiling is not changed.
    const int is_within = x * x + y * y + z * z <= most * most && x <= most && -x <= most && y <= most &&
                          -y <= most && z <= most && -z <= most;
    const int are_numbers = x == x && y == y && z == z;
    const int holds = !is_within || !are_numbers || (fx == x && fy == y && fz == z);
#elif CLAIM == 9  // Wrong where one is no number: a prover that shows this knows no such doubles.
    const int holds = x <= y || y <= x;
#endif
    //@ check holds: holds;
}
