#pragma once

#include <filesystem>

#include "engine/result.hpp"

namespace touchable {

/// Gives a file that is no right one the name FILE.broken, or FILE.broken2 and so on where there are such:
/// that name. Nobody's work is written over.
Result<std::filesystem::path> set_aside(const std::filesystem::path& file);

}  // namespace touchable
