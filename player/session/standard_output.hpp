#pragma once

#include <filesystem>

#include "engine/result.hpp"

namespace touchable {

/// Whether an output's name, "-", means standard output ("./-" is a file of that name).
bool is_standard_output(const std::filesystem::path& name);

/// Writes out what was said. Fails (ErrorKind::input) where it cannot be written; a reader that has gone away
/// (`| head`) has heard what it wanted to hear and is no failure.
Result<void> flush_standard_output();

}  // namespace touchable
