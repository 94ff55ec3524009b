#pragma once

#include <string>
#include <vector>

#include "bench/report.hpp"

namespace touchable {

struct Limit {
    double value = 0;
    bool may_equal = false;
    std::string unit;
};

/// A limit that a metric of the suite `touch` has to keep in every one of some cases.
struct Target {
    std::string what;       ///< for a person
    std::string elsewhere;  ///< what is known of others; may be empty
    std::vector<std::string> cases;
    std::string metric;
    Limit limit;
    /// Where given, what counts is the metric over that of this case.
    std::string relative_to;
};

/// What the touch solver is to reach (bench/README.md, "Targets").
const std::vector<Target>& touch_targets();

/// How a target fared: its largest value over the cases that were measured.
struct Verdict {
    double value = 0;
    std::size_t cases = 0;  ///< of the target's, that have the metric; 0: not measured, so not met
    bool met = false;
};
Verdict judge(const Target& target, const std::vector<CaseFigures>& measured);

/// A line per target: what, known elsewhere, limit, measured, met or missed.
std::string table_of(const std::vector<Target>& targets, const std::vector<CaseFigures>& measured);

}  // namespace touchable
