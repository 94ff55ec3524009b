#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `init-scene`: writes the scene file of pictures that have none.
void add_init_scene_command(CLI::App& app, Command& command);

}  // namespace touchable
