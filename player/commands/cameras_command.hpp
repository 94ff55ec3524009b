#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `touchable cameras`: those that are plugged in, and how they are touched.
void add_cameras_command(CLI::App& app, Command& command);

}  // namespace touchable
