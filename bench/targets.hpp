// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bench/report.hpp"

namespace touchable {

struct Limit {
    enum class Sense { below, at_most, at_least, none };  ///< none: shown without a limit

    double value = 0;
    Sense sense = Sense::below;
    std::string unit;
};

/// A limit that a metric must keep in each of some cases.
struct Target {
    std::string what;  ///< description
    std::vector<std::string> cases;
    std::string metric;
    Limit limit;
    /// If given, the limit applies to the metric divided by this case's.
    std::string relative_to = {};
    /// If given, cases in which this metric is not 1 are skipped.
    std::string only_where = {};
};

/// Targets of the touch solver and of the frame pipeline (bench/README.md, "Targets").
const std::vector<Target>& touch_targets();
const std::vector<Target>& surface_targets();
/// Targets of forces on real cameras' depth.
const std::vector<Target>& real_targets();
/// Targets of clips that are touched while they play.
const std::vector<Target>& live_targets();
/// Targets of the window.
const std::vector<Target>& play_targets();

/// Those of the solver and of the frame pipeline together.
const std::vector<Target>& both_targets();

/// Result of a target: its worst value over the measured cases.
struct Verdict {
    double value = 0;
    std::size_t cases = 0;  ///< number of the target's cases with the metric; 0: not measured, so not met
    bool met = false;
    bool asked = true;  ///< false: all measured cases were skipped (Target::only_where)
    std::string worst;  ///< case of the value
};
Verdict judge(const Target& target, const std::vector<CaseFigures>& measured);

/// The targets with at least one measured case; a case filter may exclude some.
std::vector<Target> measured_targets(std::vector<Target> targets, const std::vector<CaseFigures>& measured);

/// A line per target: description, limit, measured value, met or missed.
std::string table_of(const std::vector<Target>& targets, const std::vector<CaseFigures>& measured);

/// The measured ones as records, a case per target, named after its description (after that of the line that
/// it is indented under, too): worst value, its case, metric, limit and verdict. Units refer to `targets`.
std::vector<CaseFigures> records_of(const std::vector<Target>& targets,
                                    const std::vector<CaseFigures>& measured);

}  // namespace touchable
