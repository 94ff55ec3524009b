#pragma once

#include <functional>
#include <memory>
#include <string>

#include "bench/suite.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// Makes a builder of the same kind and scene each time.
using MakeBuilder = std::function<Result<std::unique_ptr<SurfaceBuilder>>()>;

/// Frames of which a share of the tiles changes against whole ones, by the same kind of builder in turn: 1,
/// 10, 30 and 100 % of them, `dirty` in one disc, `_scattered` with all their pixels, `_speckled` with a
/// single one; and `unchanged` ones, all under names that begin with `prefix`. Times are of a frame, the mean
/// of a few. An error where any frame differs from the whole one.
Result<void> race_changed(const RawFrame& raw, const std::string& prefix, const MakeBuilder& make_builder,
                          int rounds, Figures& figures);

}  // namespace touchable
