// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {

/// A soak does units in turn: unit n is suite n mod their number, seed n / their number, `unit_ticks` ticks.
struct SoakPlan {
    std::int64_t unit_ticks = 20000;
    int certify_every = 8, compare_every = 512;
    int replay_every = 32;  ///< units: done twice, for the same bits (S6)
    /// Fingerprint of the solver: the forces of a short run of every suite. Ticks of another solver prove
    /// nothing of this one.
    std::string solver;
    bool operator==(const SoakPlan&) const = default;
};

/// How far a soak has come.
struct SoakState {
    SoakPlan plan;
    std::int64_t units = 0;                                 ///< all units below this one are done
    std::map<std::string, Coverage, std::less<>> coverage;  ///< by suite
    std::int64_t violation_count = 0;
    std::vector<std::string> violations;  ///< the first hundred, each with what reproduces it

    std::int64_t ticks() const;
    void add(const Suite& suite, std::uint64_t seed, const Watched& watched);
    /// Suites that met with nothing, one line each.
    std::vector<std::string> empty_suites() const;
};

/// XXH64 digits of a short run of every suite.
std::string solver_identity();

/// Nothing where there is no such file; refuses one that is no soak's.
Result<std::optional<SoakState>> read_soak(const std::filesystem::path& file);
/// Appears whole or not at all.
Result<void> write_soak(const std::filesystem::path& file, const SoakState& state);

struct SoakSettings {
    SoakPlan plan;  ///< its `solver` is filled in
    std::int64_t ticks = 1'000'000'000;
    int threads = 2;
    std::filesystem::path state = "out/soak/state.json";
    bool fresh = false;  ///< forget what the state file says
};

/// Goes on where the state file ends until all ticks are done or it is interrupted, on all threads, and
/// writes the state every few seconds. An error of kind check where an invariant was violated or a suite met
/// with nothing; one of kind usage where the state is of another solver or plan.
Result<SoakState> soak(const SoakSettings& settings, std::ostream& progress);

}  // namespace touchable::stress
