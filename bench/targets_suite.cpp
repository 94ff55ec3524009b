// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "bench/suite.hpp"
#include "bench/targets.hpp"

namespace touchable {
namespace {

/// The cases needed by these targets.
std::vector<BenchCase> needed(std::vector<BenchCase> cases, const std::vector<Target>& targets) {
    std::erase_if(cases, [&](const BenchCase& c) {
        return std::ranges::none_of(targets, [&](const Target& target) {
            return c.name == target.relative_to || std::ranges::count(target.cases, c.name) > 0;
        });
    });
    return cases;
}

}  // namespace

const std::vector<Target>& both_targets() {
    static const std::vector<Target> both = [] {
        std::vector<Target> targets = touch_targets();
        std::ranges::copy(surface_targets(), std::back_inserter(targets));
        return targets;
    }();
    return both;
}

std::vector<BenchCase> target_cases(bool quick) {
    std::vector<BenchCase> cases = needed(touch_cases(quick), touch_targets());
    std::ranges::move(needed(surface_cases(quick), surface_targets()), std::back_inserter(cases));
    return cases;
}

Result<void> conclude_targets(const std::vector<CaseFigures>& measured) {
    const std::vector<Target> targets = measured_targets(both_targets(), measured);
    const auto missed = std::ranges::count_if(targets, [&](const Target& target) {
        const Verdict verdict = judge(target, measured);
        return verdict.asked && !verdict.met;
    });
    if (missed == 0) return {};
    return Error{ErrorKind::check,
                 std::to_string(missed) + " of " + std::to_string(targets.size()) + " targets missed"};
}

}  // namespace touchable
