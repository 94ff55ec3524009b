#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "player/run/playback_clock.hpp"

namespace touchable {

/// How the clip is played, as typed.
struct PlaybackTyped {
    std::optional<double> start;  ///< seconds
    std::optional<double> rate;
    std::vector<double> loop;  ///< seconds: none, or begin and end
    std::optional<std::filesystem::path> script;
};

/// --start, --rate, --loop and --play.
std::vector<CLI::Option*> add_playback_options(CLI::App& sub, PlaybackTyped& typed);

/// What is typed takes effect with the first tick, before what a script says of it. A loop is begun with
/// where no --start says otherwise.
Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed);

}  // namespace touchable
