#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "player/run/playback_clock.hpp"

namespace touchable {

/// What a person wants of the clip's clock, one command a line: "SECONDS play", "pause", "rate X", "seek
/// SECONDS", "step", "loop SECONDS SECONDS" or "unloop", in the order of their times (docs/playback.md).
/// Empty lines and what follows '#' say nothing. Refuses (ErrorKind::input), with `name` and the line, all
/// else.
Result<std::vector<PlaybackCommand>> parse_playback(std::string_view text, const std::string& name);
/// Likewise, of a file.
Result<std::vector<PlaybackCommand>> read_playback(const std::filesystem::path& file);

/// What a person may have set to give these commands.
Hints settings_of(const std::vector<PlaybackCommand>& commands);
/// As such lines, with ", " between them.
std::string in_words(const std::vector<PlaybackCommand>& commands);

}  // namespace touchable
