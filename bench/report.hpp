#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// Aligned tables: one for each stretch of cases that have the same metrics, a row per case; of cases with
/// more metrics than fit beside each other (30), one for up to 10, a row per metric. Figures that are for
/// plots alone are left out.
std::string tables_of(const std::vector<CaseFigures>& measured);

/// Whether the report could be written there; leaves nothing behind. To be asked before hours of measuring.
Result<void> check_writable(const std::filesystem::path& file);
/// An array of {suite, case, metric, value, unit}, where a value is a number or a name. The file appears
/// whole or not at all.
Result<void> write_report(const std::filesystem::path& file, std::string_view suite,
                          const std::vector<CaseFigures>& cases);

}  // namespace touchable
