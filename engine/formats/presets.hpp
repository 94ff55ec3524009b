#pragma once

#include <optional>
#include <span>
#include <string>

#include "engine/formats/source_description.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What is known of the pictures of a data set, a camera or a program.
struct Preset {
    const char* name;
    const char* what;            ///< in words
    Intrinsics intrinsics;       ///< fx 0: `fov` tells, or a file beside the pictures
    double fov = 0;              ///< from edge to edge, degrees
    double metres_per_code = 0;  ///< 0: not metric
    int invalid = 0;             ///< a code that is no depth, beside 0
    StoredDepth stored{};
};

std::span<const Preset> all_presets();
/// Null: there is none of that name.
const Preset* preset_named(const std::string& name);

/// What of a video's pixels depth is, by a name that `--preset` has for videos alone: hue, mean.
std::optional<VideoValues> video_values_named(const std::string& name);

}  // namespace touchable
