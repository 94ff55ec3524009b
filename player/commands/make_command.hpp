#pragma once

namespace CLI {
class App;
}

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/content/globe_maps.hpp"
#include "engine/content/scenes.hpp"
#include "engine/picture/image.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {

/// A globe of maps as a person asks for one.
struct GlobeMapFiles {
    std::filesystem::path colour, elevation, mask, haptic;
    std::optional<double> sea_level{}, relief_percent{}, smoothing_degrees{};

    bool any() const { return !colour.empty() || !elevation.empty() || !mask.empty(); }
    /// Those that are read, as they were named.
    std::vector<NamedFile> files() const;
};

/// What belongs to globes alone.
struct GlobeWords {
    GlobeMapFiles maps;
    std::optional<double> seconds_per_turn{}, axial_tilt{}, longitude{};
};
void add_globe_options(CLI::App& make, GlobeWords& words);

/// Refuses what would do nothing for `scene`, and maps that lack another.
Result<void> check_globe_words(const GlobeWords& words, const std::string& scene, bool plain);
void take_motion(const GlobeWords& words, SceneOptions& options);

/// Maps with the pictures that they lie in.
struct ReadGlobeMaps {
    StoredImage colour{}, elevation{}, mask{}, haptic{};
    GlobeMaps maps;
    std::string remark;  ///< one line: what was found of the sea level
};
Result<std::unique_ptr<const ReadGlobeMaps>> read_globe_maps(const GlobeMapFiles& files);

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
