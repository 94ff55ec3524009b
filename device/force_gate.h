// SPDX-License-Identifier: Apache-2.0
#pragma once

// The last gate: every force passes it on its way to a device, after guard, control and ramps. It is one
// function in plain C, so that a prover reads the lines that run: `./run prove` (tests/proof/) proves the
// promises below for all double values of every argument. The result has passed a comparison for each of
// them.
//
// Beyond what the prover shows: with a constant ramp, n calls after a ceiling of 0 no force is longer than n
// ramps. And if the sum of the squares, as computed, is at most ceiling * ceiling as computed, then |force|
// <= ceiling (1 + 2^-51): squares and sums of three terms round by at most 3 * 2^-53 of the result, the
// product by 2^-53, and the root halves both (squares that underflow add less than 1e-161 N). Each component
// is within the ceiling without any rounding. This holds for IEEE 754 arithmetic, so for code compiled with
// -ffp-contract=off and without -ffast-math.
// Threads: any; a pure function.

#include <math.h>

/// Limits a finger's force, N, to the ceiling, and returns that ceiling for the next call. `ceiling`: what
/// the last call returned; 0 before the first one and after each gap. `limit`: the longest force that the
/// device exerts, N, at most 1e9. `ramp`: by how much the ceiling may rise in this call, N.
/// - 0 <= the new ceiling <= limit; it is also at most ceiling + ramp, as computed.
/// - Each component is finite and at most the new ceiling, and so is the length, up to rounding (above).
/// - A force within the ceiling is unchanged to the bit. A longer one is shortened and keeps its direction.
/// - A force that is NaN or infinite becomes 0, and so does one whose squares overflow (1e154 N).
/// - If limit, ceiling or ramp is NaN, or their results are not 0 to 1e9, the new ceiling is 0.
/// Any thread; neither waits nor allocates.
static inline double force_gate(double newtons[3], double ceiling, double limit, double ramp) {
    double x = newtons[0], y = newtons[1], z = newtons[2];
    const double risen = ceiling + ramp;
    double most = risen < limit ? risen : limit;
    if (!(0 <= most && most <= limit && most <= risen && most <= 1e9)) most = 0;
    const double square = x * x + y * y + z * z;
    if (!(square <= most * most)) {
        double share = most / sqrt(square);
        const double sx = x * share, sy = y * share, sz = z * share;
        if (sx * sx + sy * sy + sz * sz > most * most) share *= 1 - 0x1p-49;  // more than any rounding
        x *= share;
        y *= share;
        z *= share;
    }
    // Each comparison is false for NaN.
    if (!(x * x + y * y + z * z <= most * most && x <= most && -x <= most && y <= most && -y <= most &&
          z <= most && -z <= most))
        x = y = z = 0;
    newtons[0] = x;
    newtons[1] = y;
    newtons[2] = z;
    return most;
}
