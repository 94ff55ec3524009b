#pragma once

#include <string>
#include <vector>

#include "haptics_cpu/touch_step.hpp"
#include "tests/stress/coverage.hpp"
#include "tests/stress/stress_run.hpp"

namespace touchable::stress {

struct WatchSettings {
    std::int64_t ticks = 2000;
    int certify_every = 1;   ///< ticks; 0: never
    int compare_every = 16;  ///< ticks, with the reference solver; 0: never
};

/// What came of a run. A violation names tick, finger and invariant.
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
/// and at those asked for:
///   S8 stiffness is the reference's
///   S2 the certificate: a minimum of the distance, or held by friction; capped ticks are exempt
///   and |P - G| at most 1.0001 of the reference solver's from the same state, in the same basin within 1e-7
///   degrees; other basins are counted.
/// S6, the same bits again, is for the caller: watch twice and compare the hashes.
Watched watch(StressRun& run, const WatchSettings& settings, TickSink* sink = nullptr);

}  // namespace touchable::stress
