#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "player/run/force_comparison.hpp"
#include "player/run/force_table.hpp"

namespace touchable {

/// How long it takes, in ticks: milliseconds.
inline constexpr std::int64_t standard_stroke_ticks = 3000;

/// What one finger did, and what it felt.
struct Stroke {
    ForceTable forces;
    double metres_per_scene_unit = 0;
};

/// Of one that wanders over a clip, always on the same way. The clip has the filters that it states, or that
/// its first frames ask for, here and below.
Result<Stroke> standard_stroke(std::unique_ptr<ClipReader> clip);
/// What the same hand feels of two clips that show the same: the very goals of a stroke over the first are
/// repeated over the second, at the same scale.
Result<ForceComparison> compare_by_stroke(const Stroke& first, std::unique_ptr<ClipReader> second);

}  // namespace touchable
