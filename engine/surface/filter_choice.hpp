#pragma once

#include <optional>

#include "engine/base/result.hpp"
#include "engine/scene/scene_description.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {

/// Whether terrace removal is worth while: enough kappa with the measured levels, and room for it.
bool removal_advised(const MeasuredDepth& measured, const Scene& scene);

/// Settles the filters that a scene's description leaves open, and TerraceRemoval::automatic, by what was
/// measured of its frames; nothing measured: they stay off. Terraces are removed and temporal noise is
/// averaged as the measured levels and noise say, where the scene does not state these. docs/real-depth.md
/// has the measurements behind each rule.
void choose_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                    Scene& scene);

/// Whether frames have to be measured for `settle_filters`.
bool needs_measuring(const UnstatedFilters& unstated, const Scene& scene);
/// `choose_filters`, then refuses (ErrorKind::usage) a scene that cannot be filtered so: by the temporal
/// filter where neither scene nor frames say how noisy depth is.
Result<void> settle_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                            Scene& scene);

}  // namespace touchable
