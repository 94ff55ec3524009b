#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "engine/new_file.hpp"
#include "engine/result.hpp"
#include "player/options/command.hpp"
#include "player/options/picture_options.hpp"
#include "player/session/builder_choice.hpp"
#include "player/session/clip_choice.hpp"

namespace CLI {
class App;
}

namespace touchable {

struct ExportOptions {
    ClipChoice clip;
    std::filesystem::path out;           ///< empty: only the picture
    Existing existing = Existing::keep;  ///< what becomes of files that are there
    std::int64_t first = 0;
    std::optional<std::int64_t> last;  ///< inclusive; nothing: to the end
    bool folder_per_frame = false;     ///< out/<n>/ instead of out/
    bool mesh = true;
    BuilderChoice builder;
    PictureOptions picture;  ///< of a single frame
};

/// Writes frames as pictures, mesh and scene description: colour.png, depth.png (as stored), codes.png
/// (filtered, 16 bits), valid.png (0 or 255), haptic.png and height.png where the clip has them, mesh.ply,
/// scene.json. The files of a frame appear together or not at all. The picture of a single frame is a file of
/// its own.
Result<void> run_export(const ExportOptions& options);

void add_export_command(CLI::App& app, Command& command);

}  // namespace touchable
