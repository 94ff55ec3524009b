// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/loop/closed_loop.hpp"

namespace touchable {

/// Theoretical limits of a virtual wall of stiffness K, sampled every T and held, N/m. T is
/// ClosedLoop::period_s. Passive, with any hand: K < 2 b / T (Colgate and Schenkel 1997).
double colgate_schenkel_bound(const HandleDynamics& handle);
/// Stable, with forces delayed by t_d: K < b / (T/2 + t_d) (Gil, Sanchez, Hulin, Preusche and Hirzinger
/// 2009).
double gil_bound(const HandleDynamics& handle, int delay_ticks);
/// Passive, read in quanta D, with Coulomb friction f: K <= min(2 b / T, 2 f / D) (Abbott and Okamura 2005).
/// Without a quantum: Colgate and Schenkel's limit.
double abbott_okamura_bound(const HandleDynamics& handle);

/// Outcome for a nudged finger.
enum class LoopFate { rests, shakes, leaves };

/// Presses a finger on a place, nudges it, and observes it. It shakes if its motion (on a moving surface:
/// relative to a finger without a nudge) has not decreased over a time in which that of a loop one per cent
/// below the flat wall's boundary would decrease by 5 %, or if it is much larger than the nudge. It has left
/// if it rests without contact.
Result<LoopFate> fate_of(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place,
                         double stiffness);

/// The stiffness, N/m, up to which a finger on a place comes to rest: increased in steps of a factor of
/// sqrt(2) from 20 N/m, then bisected to 1 %. The increase ends at `highest_stiffness`, or when the finger
/// presses less deep than one quantum of its readings, or rests above the surface. An error if it slides off
/// even when pressed softly.
inline constexpr double highest_stiffness = 200'000;
Result<double> stability_boundary(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place);

}  // namespace touchable
