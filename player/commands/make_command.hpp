#pragma once

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/content/globe_maps.hpp"
#include "engine/content/scenes.hpp"
#include "engine/picture/image.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {

/// Files and options of a globe made from maps.
struct GlobeMapFiles {
    std::filesystem::path colour, elevation, mask, haptic;
    std::optional<double> sea_level{}, relief_percent{}, smoothing_degrees{};

    bool any() const { return !colour.empty() || !elevation.empty() || !mask.empty(); }
    /// The files that are read, with their options.
    std::vector<NamedFile> files() const;
};

/// Maps with the pictures that hold their samples.
struct ReadGlobeMaps {
    StoredImage colour{}, elevation{}, mask{}, haptic{};
    GlobeMaps maps;
    std::string remark;  ///< one line about the sea level found
};
Result<std::unique_ptr<const ReadGlobeMaps>> read_globe_maps(const GlobeMapFiles& files);

}  // namespace touchable
