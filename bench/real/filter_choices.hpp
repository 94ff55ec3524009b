#pragma once

#include <optional>
#include <string_view>
#include <vector>

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

/// The program's choice if nothing is stated.
Scene chosen_filters(const std::vector<RawFrame>& first, Scene scene);

/// In the order of the tables. A new choice is a function and a line here.
const std::vector<FilterChoice>& filter_choices();

}  // namespace touchable
