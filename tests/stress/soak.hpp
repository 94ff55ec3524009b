#pragma once

#include <filesystem>
#include <ostream>

#include "tests/stress/soak_state.hpp"

namespace touchable::stress {

struct SoakSettings {
    SoakPlan plan;  ///< its `solver` is filled in
    std::int64_t ticks = 1'000'000'000;
    int threads = 2;
    std::filesystem::path state = "out/soak/state.json";
    bool fresh = false;  ///< forget what the state file says
};

/// Goes on where the state file ends until all ticks are done or somebody interrupts, on all threads, and
/// writes the state every few seconds. An error of kind check where an invariant was violated or a suite met
/// with nothing; one of kind usage where the state is of another solver or plan.
Result<SoakState> soak(const SoakSettings& settings, std::ostream& progress);

}  // namespace touchable::stress
