#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/content/globe_maps.hpp"
#include "engine/content/scenes.hpp"
#include "engine/picture/stored_image.hpp"
#include "player/commands/outputs.hpp"

namespace CLI {
class App;
}

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

}  // namespace touchable
