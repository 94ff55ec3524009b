#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// Aligned tables. Of few cases (10 at most) one with a column per case and a row per metric; of more, one
/// for each stretch of cases that have the same metrics, a row per case.
std::string tables_of(const std::vector<CaseFigures>& cases);

/// Whether the report could be written there; leaves nothing behind. To be asked before hours of measuring.
Result<void> check_writable(const std::filesystem::path& file);
/// An array of {suite, case, metric, value, unit}. The file appears whole or not at all.
Result<void> write_report(const std::filesystem::path& file, std::string_view suite,
                          const std::vector<CaseFigures>& cases);

}  // namespace touchable
