#pragma once

#include <string>
#include <vector>

#include "bench/report.hpp"

namespace touchable {

struct Limit {
    enum class Sense { below, at_most, at_least, none };  ///< none: only shown, beside what has a limit

    double value = 0;
    Sense sense = Sense::below;
    std::string unit;
};

/// A limit that a metric has to keep in every one of some cases.
struct Target {
    std::string what;  ///< for a person
    std::vector<std::string> cases;
    std::string metric;
    Limit limit;
    /// Where given, what counts is the metric over that of this case.
    std::string relative_to = {};
    /// Where given, cases in which this metric is not 1 are not asked.
    std::string only_where = {};
};

/// What the touch solver is to reach, and what the frame pipeline (bench/README.md, "Targets").
const std::vector<Target>& touch_targets();
const std::vector<Target>& surface_targets();
/// What a finger is to feel of depth that a real camera stored.
const std::vector<Target>& real_targets();
/// Clips that are touched while they play.
const std::vector<Target>& live_targets();
/// The window.
const std::vector<Target>& play_targets();

/// How a target fared: its worst value over the cases that were measured.
struct Verdict {
    double value = 0;
    std::size_t cases = 0;  ///< of the target's, that have the metric; 0: not measured, so not met
    bool met = false;
    bool asked = true;  ///< false: of the cases that were measured none is one to ask (Target::only_where)
};
Verdict judge(const Target& target, const std::vector<CaseFigures>& measured);

/// Those that stand on a case which was measured: with a filter some do not.
std::vector<Target> measured_targets(std::vector<Target> targets, const std::vector<CaseFigures>& measured);

/// A line per target: what, limit, measured, met or missed.
std::string table_of(const std::vector<Target>& targets, const std::vector<CaseFigures>& measured);

}  // namespace touchable
