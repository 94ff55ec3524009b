#pragma once

#include <memory>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"
#include "player/session/force_comparison.hpp"

namespace touchable {

/// How long it takes, in ticks: milliseconds.
inline constexpr std::int64_t standard_stroke_ticks = 3000;

/// What the same hand feels of two clips that show the same: one finger wanders over the first, always on the
/// same way, and its very goals are repeated over the second, at the same scale. Each clip has the filters
/// that it states, or that its first frames ask for.
Result<ForceComparison> compare_by_stroke(std::unique_ptr<ClipReader> a, std::unique_ptr<ClipReader> b);

}  // namespace touchable
