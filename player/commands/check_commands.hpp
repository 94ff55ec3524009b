#pragma once

#include "player/commands/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

// As in player/commands/commands.hpp.

/// What this machine is and whether it can do the work, or what a device does.
void add_check_command(CLI::App& app, Command& command);
/// Which devices are connected and whether they are ready, and every word that --device takes.
void add_devices_command(CLI::App& app, Command& command);

}  // namespace touchable
