#pragma once

#include <filesystem>
#include <optional>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"
#include "player/commands/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

struct InfoOptions {
    std::filesystem::path clip;
    std::optional<std::filesystem::path> scene;
    std::optional<PictureCamera> camera;  ///< of a single depth picture
    bool json = false;
};

/// Prints what a clip is, for a person or (the same facts) as one JSON object.
Result<void> run_info(const InfoOptions& options);

void add_info_command(CLI::App& app, Command& command);

}  // namespace touchable
