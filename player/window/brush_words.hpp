#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/authoring/segment_names.hpp"
#include "engine/base/result.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// "X,Y" or "X,Y,FRAME": a pixel's column and row up to 16383, and its frame, all from 0; without a frame it
/// is -1. Nothing where it is none.
std::optional<PixelOfFrame> read_pixel_of_frame(std::string_view word);

/// A command of the brush, or of measuring: what follows its first word, `name`. Refused (ErrorKind::usage)
/// with what would be right.
Result<WindowCommand> read_tool_words(WindowVerb verb, const std::string& name, const std::string& rest);

}  // namespace touchable
