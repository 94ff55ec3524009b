// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// Aligned tables: one per group of consecutive cases with the same metrics, a row per case; cases with more
/// metrics than fit side by side (30) get a table per up to 10 cases, a row per metric. Figures for plots
/// only are left out.
std::string tables_of(const std::vector<CaseFigures>& measured);

/// Puts beside each error of a force's direction, `<...>_deg<...>`, the same as a multiple of what a hand
/// just notices, `<...>_jnd<...>` (engine/base/hand_thresholds.hpp).
void add_jnd(Figures& figures);

/// Whether the report can be written there; leaves no file. Call before hours of measuring.
Result<void> check_writable(const std::filesystem::path& file);
/// Writes an array of {suite, case, metric, value, unit}; a value is a number or a name. The file appears
/// whole or not at all.
Result<void> write_report(const std::filesystem::path& file, std::string_view suite,
                          const std::vector<CaseFigures>& cases);

}  // namespace touchable
