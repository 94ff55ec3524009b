// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {

/// A way to filter depth, and its name in the benchmark.
struct FilterChoice {
    std::string_view name;
    /// The scene with these filters, set up from its first frames.
    Scene (*of)(const std::vector<RawFrame>& first, Scene scene);
};

/// The program's measurement of the first frames.
std::optional<MeasuredDepth> measured_depth(const std::vector<RawFrame>& first, const Scene& scene);

/// The program's choice if nothing is stated, from the first frames or their measurement.
Scene chosen_filters(const std::optional<MeasuredDepth>& measured, Scene scene);
Scene chosen_filters(const std::vector<RawFrame>& first, Scene scene);

/// MeasuredDepth::trusted_to, or infinity.
double trusted_to(const FilterSettings& filter, const std::optional<MeasuredDepth>& measured);

/// Appends the frontier between detailed and smooth that these frames have: `points`, and of each point k
/// from as recorded on, detail_<k>_leans_deg, what is left of noise, and detail_<k>_pen_mm, the least pen of
/// which 80 % is kept; chosen_detail, the program's choice by its k.
void add_details(const std::vector<RawFrame>& first, const Scene& scene, Figures& figures);

/// In the order of the tables. A new choice is a function and a line here.
const std::vector<FilterChoice>& filter_choices();

}  // namespace touchable
