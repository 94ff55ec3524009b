#pragma once

#include <functional>

#include "engine/base/result.hpp"

namespace touchable {

/// What the command line asked for, with its options filled in; an `add_*_command` sets it once its words are
/// read.
using Command = std::function<Result<void>()>;

}  // namespace touchable
