#pragma once

#include <optional>
#include <string>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What the first frames of a clip say of its depth (DepthSurvey).
struct MeasuredDepth {
    double median = 0;             ///< of what is there to touch, scene units
    DepthLength levels;            ///< zero: every code is one
    double distance = 0;           ///< from one level to the next at the median, scene units
    double kappa = 0;              ///< there, with these levels
    bool advised = false;          ///< terrace removal is worth while
    std::string in_words() const;  ///< "levels 12.3 units apart at 1861 (kappa 3.5)"
};

/// Looks at the first frames, and goes back to the beginning. Levels that the scene states count as stated.
/// Nothing where no pixel is valid.
Result<std::optional<MeasuredDepth>> measure_depth(ClipReader& reader, const Scene& scene);

/// Where the scene asks for terrace removal: levels that it does not state are measured, and `auto` becomes
/// on or off. What to tell a person; nothing: nothing was measured.
Result<std::optional<std::string>> settle_terraces(ClipReader& reader, Scene& scene);

}  // namespace touchable
