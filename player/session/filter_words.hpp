#pragma once

#include <optional>
#include <string>

#include "player/session/chosen_filters.hpp"

namespace touchable {

/// The filters of a scene and the reason for each: "terraces (levels 11.4 mm apart at 2 m), temporal for 3.2
/// mm (noise 2.1 mm), no median (roughness 0.1 mm, 0.02 of a pixel's width)"; "stated" is the reason of those
/// that were not chosen.
std::string filters_in_words(const Scene& scene, const std::optional<ChosenFilters>& chosen);
/// "12.3 mm apart at 1.86 m (kappa 3.47)".
std::string levels_in_words(const MeasuredDepth& measured, double metres_per_unit);
/// "2.1 mm from frame to frame, 5 mm at edges; roughness 0.31 mm", or that none was found.
std::string noise_in_words(const MeasuredDepth& measured, double metres_per_unit);

}  // namespace touchable
