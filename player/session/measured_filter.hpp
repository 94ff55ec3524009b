#pragma once

#include <optional>
#include <string>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_survey.hpp"

namespace touchable {

/// What the first frames of a clip say of its depth (DepthSurvey).
struct MeasuredDepth {
    double metres_per_unit = 0.001;
    double median = 0;             ///< of what is there to touch, scene units
    DepthLength levels;            ///< zero: every code is one
    double distance = 0;           ///< from one level to the next at the median, scene units
    double kappa = 0;              ///< there, with these levels
    bool advised = false;          ///< terrace removal is worth while
    std::string in_words() const;  ///< "levels 12.3 mm apart at 1.86 m (kappa 3.47)"
};

/// Levels that the scene states count as stated. Nothing where no pixel is valid.
std::optional<MeasuredDepth> measured_depth(const DepthSurvey& survey, const Scene& scene);

/// The same of the first frames; goes back to the beginning.
Result<std::optional<MeasuredDepth>> measure_depth(ClipReader& reader, const Scene& scene);

/// Where the scene asks for terrace removal: levels that it does not state are measured, and `auto` becomes
/// on or off. What to tell a person; nothing: nothing was measured.
Result<std::optional<std::string>> settle_terraces(ClipReader& reader, Scene& scene);

}  // namespace touchable
