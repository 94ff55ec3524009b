#pragma once

#include <nlohmann/json.hpp>

namespace touchable::test {

/// What a live run tells of itself: the machine stood still, or had other work, for a quarter of it and more.
/// What a hand would have felt then was not felt. Nothing is to be learned of such a run, and it is run
/// again.
inline bool stood_still(const nlohmann::json& report) {
    if (!report.is_object() || !report.contains("skipped_ticks")) return false;
    return report["skipped_ticks"].get<double>() > 0.25 * report["ticks"].get<double>();
}

/// That so many runs in a row stand still is no chance any more: the last one counts.
inline constexpr int most_standstills = 8;

}  // namespace touchable::test
