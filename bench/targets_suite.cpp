#include <algorithm>
#include <iostream>

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

std::vector<BenchCase> target_cases(bool quick) {
    std::vector<BenchCase> cases = needed(touch_cases(quick), touch_targets());
    std::ranges::move(needed(surface_cases(quick), surface_targets()), std::back_inserter(cases));
    return cases;
}

Result<void> conclude_targets(const std::vector<CaseFigures>& measured) {
    std::ptrdiff_t missed = 0, all = 0;
    for (const auto& [of, targets] :
         {std::pair{"the touch solver", &touch_targets()}, std::pair{"frames", &surface_targets()}}) {
        std::cout << "\nTargets of " << of << "\n\n" << table_of(*targets, measured) << std::flush;
        missed += std::ranges::count_if(*targets, [&](const Target& target) {
            const Verdict verdict = judge(target, measured);
            return verdict.asked && !verdict.met;
        });
        all += std::ssize(*targets);
    }
    if (missed == 0) return {};
    return Error{ErrorKind::check, std::to_string(missed) + " of " + std::to_string(all) + " targets missed"};
}

Result<void> conclude_surface(const std::vector<CaseFigures>& measured) {
    std::cout << '\n' << table_of(measured_targets(surface_targets(), measured), measured) << std::flush;
    return {};
}

Result<void> conclude_touch(const std::vector<CaseFigures>& measured) {
    const std::vector<Target> targets = measured_targets(real_targets(), measured);
    if (!targets.empty()) std::cout << '\n' << table_of(targets, measured) << std::flush;
    return {};
}

}  // namespace touchable
