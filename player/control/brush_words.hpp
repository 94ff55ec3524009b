#pragma once

#include <string>

#include "engine/result.hpp"
#include "player/control/window_command.hpp"

namespace touchable {

/// A command of the brush: what follows its first word, `name`. Refused (ErrorKind::usage) with what would be
/// right.
Result<WindowCommand> read_brush_words(WindowVerb verb, const std::string& name, const std::string& rest);

}  // namespace touchable
