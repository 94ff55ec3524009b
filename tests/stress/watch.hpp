// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "haptics_cpu/touch_step.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {

/// Events of a run and its measurements; sums of several runs are sums and maxima.
struct Coverage {
    std::int64_t ticks = 0, finger_ticks = 0;
    std::int64_t contact = 0;                                       ///< finger-ticks
    std::int64_t with_heights = 0, with_friction = 0, sliding = 0;  ///< of those in contact
    std::int64_t at_invalid = 0;                ///< of those certified: a corner of the place is no depth
    std::int64_t in_holes = 0;                  ///< of those certified: stiffness is that of holes, in part
    std::int64_t landings = 0, departures = 0;  ///< contact made, contact lost
    std::int64_t frame_changes = 0, between_frames = 0;  ///< ticks
    std::int64_t held_goals = 0, refusals = 0;
    std::int64_t capped = 0, most_events = 0;
    std::int64_t certified = 0, compared = 0, other_basins = 0;
    double worst_behind = 0;                      ///< relative, of 1 / planar depth
    double worst_excess = 0;                      ///< of |P - G| over the minimum, over 1 + |P - G|
    double worst_way = 0;                         ///< scene units left to go, over 1 + |P - G|
    double worst_ratio = 0;                       ///< |P - G| over the reference's, same basin
    double worst_angle = 0;                       ///< degrees, same basin
    double energy_created = 0, energy_bound = 0;  ///< J, the most of any finger

    void add(const Coverage& other);
    double contact_share() const;
    /// The coverage that is missing; empty where none is.
    std::string missing(const Needs& needs) const;
    std::string in_words() const;  ///< one line
};

struct WatchSettings {
    std::int64_t ticks = 2000;
    int certify_every = 1;   ///< ticks; 0: never
    int compare_every = 16;  ///< ticks, with the reference solver; 0: never
};

/// Result of a run. A violation names tick, finger and invariant.
struct Watched {
    Coverage coverage;
    std::vector<std::string> violations;  ///< the first few
    std::int64_t violation_count = 0;
    std::string force_hash;
};

/// Takes what happens tick by tick: the fingers' states after the tick, and the tick.
class TickSink {
public:
    virtual ~TickSink() = default;
    virtual void take(const TouchTick& tick, std::span<const FingerState> fingers) = 0;
};

/// Touches as the program does and asserts, at every tick:
///   S1 no proxy is behind the surface (long double)        S3 nothing is infinite or NaN
///   S4 |F| is at most the guard's, and 0 out of contact    S5 no more events than the limit
///   S7 no more energy comes from nowhere than holding a force for a tick explains: in each tick where
///      stiffness is the same everywhere, since the start where its rise has to be paid for
///   S9 the force that is sent changes by no more than the hand's motion, the hand's share of what the
///      solver's own force changes otherwise, and the fade explain (docs/solver.md, Sudden change)
/// and at those asked for:
///   S8 stiffness is the reference's
///   S2 the certificate: a minimum of the distance, or held by friction; capped ticks are exempt
///   and |P - G| at most 1.0001 of the reference solver's from the same state, in the same basin within 1e-7
///   degrees; other basins are counted.
/// S6, the same bits again, is for the caller: watch twice and compare the hashes.
Watched watch(StressRun& run, const WatchSettings& settings, TickSink* sink = nullptr);

}  // namespace touchable::stress
