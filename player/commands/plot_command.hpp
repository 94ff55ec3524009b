#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `plot FORCES.csv PICTURE.png`: force over time, or where the proxies went over a frame.
void add_plot_command(CLI::App& app, Command& command);

}  // namespace touchable
