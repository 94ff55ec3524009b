#pragma once

#include "engine/result.hpp"
#include "player/options/command.hpp"
#include "player/session/clip_choice.hpp"

namespace CLI {
class App;
}

namespace touchable {

struct InfoOptions {
    ClipChoice clip;
    bool json = false;
};

/// Prints what a clip is, for a person or (the same facts) as one JSON object.
Result<void> run_info(const InfoOptions& options);

void add_info_command(CLI::App& app, Command& command);

}  // namespace touchable
