#pragma once

#include "engine/scene/depth_coding.hpp"
#include "engine/scene/plane_view.hpp"
#include "shaders/hue_code.h"

namespace touchable {

/// What a hue pixel has that says nothing of its depth; beyond every coding's valid codes.
inline constexpr std::uint16_t no_hue = 0xFFFF;

/// The code of a pixel of a depth plane, valid or not (DepthCoding::is_valid): the stored value, or the hue
/// of three channels.
inline std::uint16_t stored_code(const PlaneView& depth, const DepthCoding& coding, int x, int y) {
    static_assert(DepthCoding::hue_circle == HUE_CODE_CIRCLE);
    if (coding.kind != DepthCodingKind::hue) return depth.sample(x, y);
    const std::uint8_t* rgb = depth.row(y) + std::ptrdiff_t{3} * x;
    if (!hue_is_valid(rgb[0], rgb[1], rgb[2], static_cast<uint>(coding.least_sum))) return no_hue;
    return static_cast<std::uint16_t>(hue_code(rgb[0], rgb[1], rgb[2]));
}

}  // namespace touchable
