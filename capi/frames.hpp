#pragma once

#include <cstdint>
#include <vector>

#include "capi/touchable.h"
#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::capi {

/// Room for planes that modules cannot read as a program has them: floats, rows from below, samples at odd
/// places.
struct FrameScratch {
    std::vector<std::uint16_t> codes;
    std::vector<std::uint8_t> planes[4];
};

/// A program's frame as modules read it, without `storage`: it lasts as long as the program's memory and
/// `scratch`. Refused: a struct of an unknown size, planes that cannot be, floats where depth has no code for
/// "no surface".
Result<RawFrame> raw_frame(const touch_frame& frame, const Scene& scene, FrameScratch& scratch);
/// Likewise of its depth alone, which is of codes.
Result<PlaneView> depth_codes(const touch_plane& depth, const Scene& scene, FrameScratch& scratch);
/// A plane of a module as a program reads it.
touch_plane plane_for_program(const PlaneView& view);

}  // namespace touchable::capi
