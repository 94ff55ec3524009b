#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `touchable devices`: what is connected and whether it is ready, and every word that --device takes.
void add_devices_command(CLI::App& app, Command& command);

}  // namespace touchable
