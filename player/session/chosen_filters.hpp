#pragma once

#include <optional>
#include <string>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_survey.hpp"

namespace touchable {

/// What the first frames say of a clip's depth, nothing where no pixel is valid; goes back to the beginning.
Result<std::optional<MeasuredDepth>> measure_depth(ClipReader& reader, const Scene& scene);

/// Filters that were chosen by what was measured.
struct ChosenFilters {
    UnstatedFilters chosen;                 ///< which of them; the others are what the scene states
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel is valid
    double metres_per_unit = 0.001;
    FilterSettings filters;  ///< as they are applied now
};
/// Settles what the scene leaves open (choose_filters), and levels that terrace removal needs. Nothing where
/// it leaves nothing open: then no frame is read.
Result<std::optional<ChosenFilters>> settle_filters(ClipReader& reader, Scene& scene);

/// "terraces (levels 11.4 mm apart at 2 m), temporal (noise 2.1 mm), no median".
std::string in_words(const ChosenFilters& chosen);
/// "levels 12.3 mm apart at 1.86 m (kappa 3.47)".
std::string levels_in_words(const MeasuredDepth& measured, double metres_per_unit);
/// "2.1 mm from frame to frame, 5 mm at edges; 0.31 mm from pixel to pixel", or that none was found.
std::string noise_in_words(const MeasuredDepth& measured, double metres_per_unit);

}  // namespace touchable
