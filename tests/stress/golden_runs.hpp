// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <istream>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/stress/suites.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {

/// Which builder makes the frames of a golden run; the forces are the same.
enum class GoldenBuilder { cpu, lazy };

/// A generated scene and a hand over it whose forces are known to the bit: with every compiler, at every
/// level of optimisation, under sanitizers, on every machine.
struct GoldenRun {
    std::string_view name, force_hash;
    std::string_view scene, hand;  ///< of make_scene; "stroke", "walk" or "skim"
    int bits = 16;
    int fingers = 1;
    TouchMetric metric = TouchMetric::world;
    double friction = 0;      ///< static; dynamic is two thirds of it
    bool properties = false;  ///< heights and a haptic image (globe)
    int median = 0;
    FrameInterpolation interpolation = FrameInterpolation::linear;
    double hole_stiffness = 0;  ///< N/mm; above 0 the middle code of the depth is invalid

    static constexpr std::int64_t ticks = 1500;
    std::unique_ptr<StressRun> make(GoldenBuilder builder) const;
};

std::span<const GoldenRun> golden_runs();
/// A name as GoogleTest takes it.
inline std::string name_of_test(std::string_view name) {
    std::string taken(name);
    std::replace(taken.begin(), taken.end(), '-', '_');
    return taken;
}
const GoldenRun* find_golden_run(std::string_view name);

/// Everything a run went through, one line of text a tick and finger, to find where two runs part: of two
/// compilers, two builders, two versions.

/// Names of what a line holds, in order: tick, finger, goal, proxy, force and so on (the header of a file).
const std::vector<std::string>& state_fields();

/// Writes the header, then every tick. Numbers have 17 digits: equal text is equal bits (but for NaN's).
class StateWriter final : public TickSink {
public:
    explicit StateWriter(std::ostream& out);
    void take(const TouchTick& tick, std::span<const FingerState> fingers) override;

private:
    std::ostream& out_;
};

/// Compares a run with a written one as it goes, and remembers the first difference.
class StateComparison final : public TickSink {
public:
    /// `recorded` outlives this. Its header may be of another version: that is a difference.
    explicit StateComparison(std::istream& recorded);
    void take(const TouchTick& tick, std::span<const FingerState> fingers) override;
    /// "tick 17, finger 0, field force_x: 1.25, recorded 1.5", or nothing. To be asked once the run is over:
    /// what the other one has more of counts as well.
    std::optional<std::string> difference();

private:
    std::istream& recorded_;
    std::optional<std::string> difference_;
};

}  // namespace touchable::stress
