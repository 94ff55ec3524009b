#pragma once

#include <optional>

#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {

/// Whether terrace removal is worth while: enough kappa with the measured levels, and room for it.
bool removal_advised(const MeasuredDepth& measured, const Scene& scene);

/// Settles the filters that a scene leaves open (Scene::unstated, TerraceRemoval::automatic) by what was
/// measured of its frames; nothing measured: none of them. Terraces are removed and temporal noise is
/// averaged as the measured levels and noise say, where the scene does not state these. docs/real-depth.md
/// has the measurements behind each rule.
void choose_filters(const std::optional<MeasuredDepth>& measured, Scene& scene);

}  // namespace touchable
