#pragma once

#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/surface/smooth_patches.hpp"

namespace touchable {

/// Filters that were tried on a recording, and what they leave.
struct TriedFilters {
    bool temporal = false;  ///< with the noise that was measured
    int median = 0;         ///< 0, 3 or 5 pixels
    bool terraces = false;  ///< whether they are removed
    DepthLength levels;     ///< how far apart removal takes levels to be
    double harshness = 0;   ///< the more, the less is kept of edges and relief
    double left_deg = 0;    ///< how far faces of the surface are off the smooth surface around them, RMS
};

/// What the temporal filter is told of a noise that was measured: more, so that two levels beside each other,
/// too, are averaged (docs/real-depth.md).
DepthLength stated_noise(const DepthLength& measured, int median);

/// Every median, without terrace removal and with it, of levels as far apart as these, or as rough depths
/// would have, and somewhat nearer and farther; all of them without the temporal filter and with it. From the
/// mildest to the harshest. Nothing where too few places are smooth. `noise`: from frame to frame; zero:
/// there is nothing to average. Once it is asked to stop it tries no more.
std::vector<TriedFilters> tried_filters(const SmoothPatches& patches, const DepthLength& levels,
                                        const DepthLength& noise);

/// No filter, and terrace removal of these levels alone; zero: every code is one.
std::vector<TriedFilters> tried_removal(const SmoothPatches& patches, const DepthLength& levels);

/// That with this median, removal and averaging; null: it was not tried.
const TriedFilters* found_among(const std::vector<TriedFilters>& tried, const FilterSettings& filter);
/// Of those with the temporal filter, or without it, the mildest that leaves hardly more than the best; null:
/// there is none.
const TriedFilters* mildest_of_the_best(const std::vector<TriedFilters>& tried, bool temporal);

}  // namespace touchable
