#pragma once

#include "bench/loop/closed_loop.hpp"

namespace touchable {

/// What theory says of a virtual wall of stiffness K, sampled each T and held, N/m. T is
/// ClosedLoop::period_s. Passive, with any hand: K < 2 b / T (Colgate and Schenkel 1997).
double colgate_schenkel_bound(const HandleDynamics& handle);
/// Stable, with forces late by t_d: K < b / (T/2 + t_d) (Gil, Sanchez, Hulin, Preusche and Hirzinger 2009).
double gil_bound(const HandleDynamics& handle, int delay_ticks);
/// Passive, read in quanta D, with Coulomb friction f: K <= min(2 b / T, 2 f / D) (Abbott and Okamura 2005).
/// Without a quantum that of Colgate and Schenkel.
double abbott_okamura_bound(const HandleDynamics& handle);

/// What became of a nudged finger.
enum class LoopFate { rests, shakes, leaves };

/// Presses a finger on a place, nudges it, and watches. It shakes where its motion (on a surface that moves:
/// its motion apart from that of a finger not nudged) has not become quieter over a time in which a loop one
/// per cent below the flat wall's boundary would have become so by 5 %, or is much louder than the nudge. It
/// has left where it rests and touches nothing.
Result<LoopFate> fate_of(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place,
                         double stiffness);

/// The stiffness, N/m, up to which a finger on a place comes to rest: climbed to by steps of a factor of
/// sqrt(2) from 20 N/m, then bisected to 1 %. The climb ends at `highest_stiffness`, where the finger presses
/// less deep than one quantum of its readings, or where it rests above the surface. An error where it slides
/// off already when pressed softly.
inline constexpr double highest_stiffness = 200'000;
Result<double> stability_boundary(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place);

}  // namespace touchable
