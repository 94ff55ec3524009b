#pragma once

#include <filesystem>

#include "engine/base/result.hpp"

namespace touchable {

/// Renames a file that cannot be used to FILE.broken, or FILE.broken2 and so on where there are such: the new
/// name. A file that was set aside before stays.
Result<std::filesystem::path> set_aside(const std::filesystem::path& file);

}  // namespace touchable
