#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `touchable play`: a window in which a clip is watched and touched.
void add_play_command(CLI::App& app, Command& command);

}  // namespace touchable
