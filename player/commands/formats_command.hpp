#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `formats`: what can be opened, and how.
void add_formats_command(CLI::App& app, Command& command);

}  // namespace touchable
