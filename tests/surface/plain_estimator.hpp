#pragma once

#include <string>
#include <vector>

#include "engine/surface/estimators.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable::test {

/// What docs/conventions.md says is measured of a recording, in plain words and loops: every number of that
/// page stands here once more. It shares nothing with engine/surface but codes and their depths.
struct PlainEstimator {
    double median_depth = 0;  ///< 0: nothing is valid
    DepthLength levels;
    DepthLength noise_at_flat, noise_at_edges, noise_at_rims, roughness;
    double dropouts = 0, tiny_holes = 0, flying = 0, midway = 0, clean_edges = 0;

    /// Which rules decided something, by name; so a test knows that its pictures try them.
    std::vector<std::string> decided;
};
PlainEstimator plain_estimator(const DepthCoding& coding, const std::vector<CodePicture>& pictures);

}  // namespace touchable::test
