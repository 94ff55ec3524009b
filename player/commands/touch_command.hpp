#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

void add_touch_command(CLI::App& app, Command& command);

}  // namespace touchable
