#pragma once

#include <nlohmann/json.hpp>

namespace touchable::test {

/// True where the machine stood still, or had other work, for a quarter of a live run and more: forces are
/// missing. Nothing is to be learned of such a run, and it is run again.
inline bool stood_still(const nlohmann::json& report) {
    if (!report.is_object() || !report.contains("skipped_ticks")) return false;
    return report["skipped_ticks"].get<double>() > 0.25 * report["ticks"].get<double>();
}

/// So many standstills in a row are no chance any more: the last run counts.
inline constexpr int most_standstills = 8;

}  // namespace touchable::test
