#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/clip/clip_reader.hpp"
#include "engine/content/scenes.hpp"
#include "engine/new_file.hpp"
#include "engine/result.hpp"
#include "engine/video/matroska_writer.hpp"
#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

struct MakeOptions {
    std::string scene;                   ///< of scene_names()
    std::filesystem::path out;           ///< a name that ends in .mkv
    Existing existing = Existing::keep;  ///< what becomes of an earlier file of that name
    std::int64_t frames = 90;            ///< 1 to 1 000 000
    ClipStorage storage{};
    SceneOptions generator;
};

/// Writes a clip of a generated scene. The same options give the same file, byte for byte.
Result<void> run_make(const MakeOptions& options);

void add_make_command(CLI::App& app, Command& command);

}  // namespace touchable
