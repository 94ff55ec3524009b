#pragma once

#include <filesystem>
#include <string>

#include "engine/result.hpp"

namespace touchable {

/// Refuses (ErrorKind::input) what is no ordinary file, in the same words for whatever a device is given.
/// `named`: the file, for people; `right`: what would be right.
Result<void> check_given_file(const std::filesystem::path& file, const std::string& named,
                              const std::string& right);

}  // namespace touchable
