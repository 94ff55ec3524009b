#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/content/scenes.hpp"
#include "player/commands/globe_options.hpp"

namespace touchable {

/// A generated clip as it is asked for.
struct MakeOptions {
    std::string scene;                   ///< of scene_names()
    std::filesystem::path out;           ///< a name that ends in .mkv or .mp4
    Existing existing = Existing::keep;  ///< what becomes of an earlier file of that name
    std::int64_t frames = 90;            ///< 1 to 1 000 000
    ClipStorage storage{};
    SceneOptions generator;
    GlobeMapFiles maps;
};

/// Writes the clip, and says so on standard output. The same options give the same file, byte for byte.
Result<void> run_make(const MakeOptions& options);

}  // namespace touchable
