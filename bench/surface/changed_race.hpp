// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "bench/suite.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// Makes a new builder of the same kind and scene at each call.
using MakeBuilder = std::function<std::unique_ptr<SurfaceBuilder>()>;

/// Compares partly changed frames with whole ones, by the same kind of builder in turn: 10 % of the tiles
/// change, `dirty10` in one disc, `_scattered` anywhere; and `unchanged` frames. Times are per frame, the
/// mean of a few. An error if any frame differs from the whole one.
Result<void> race_changed(const RawFrame& raw, const MakeBuilder& make_builder, int rounds, Figures& figures);

}  // namespace touchable
