#include <algorithm>
#include <iostream>

#include "bench/suite.hpp"
#include "bench/targets.hpp"

namespace touchable {

std::vector<BenchCase> target_cases(bool quick) {
    const auto is_needed = [](const BenchCase& c) {
        return std::ranges::any_of(touch_targets(), [&](const Target& target) {
            return c.name == target.relative_to || std::ranges::count(target.cases, c.name) > 0;
        });
    };
    std::vector<BenchCase> cases = touch_cases(quick);
    std::erase_if(cases, [&](const BenchCase& c) { return !is_needed(c); });
    return cases;
}

Result<void> conclude_targets(const std::vector<CaseFigures>& measured) {
    std::cout << '\n' << table_of(touch_targets(), measured) << std::flush;
    const auto missed = std::ranges::count_if(
        touch_targets(), [&](const Target& target) { return !judge(target, measured).met; });
    if (missed == 0) return {};
    return Error{ErrorKind::check, std::to_string(missed) + " of " + std::to_string(touch_targets().size()) +
                                       " targets missed"};
}

}  // namespace touchable
