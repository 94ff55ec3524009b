#pragma once

#include <filesystem>

#include "engine/base/result.hpp"

namespace touchable {

/// This program's folder of a person: `touchable` in the folder that the environment's `variable` names,
/// else in `in_home` of the home folder. It need not exist. Refused where there is neither.
Result<std::filesystem::path> own_folder(const char* variable, const char* in_home);

}  // namespace touchable
