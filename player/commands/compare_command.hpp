#pragma once

#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `touchable compare A.csv B.csv`: what differs between the forces of two runs of the same hand.
void add_compare_command(CLI::App& app, Command& command);

}  // namespace touchable
