#pragma once

#include <cstdint>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// How far a surface may have moved between a pair's frames so that it is drawn on its way, scene units: the
/// `reach` of shaders/blend_rule.h.
float blend_reach(const HeightField& field);

/// Whether what is drawn is the mix of a pixel's vertices in the pair's two frames: both have depth, and not
/// so far apart that an edge has travelled over the pixel (shaders/blend_rule.h).
bool are_mixed(const HeightField& field, const FieldVertex& prev, const FieldVertex& next);

/// What is drawn at a pixel: that mix, as it is felt, or the vertex of the frame nearer in time.
FieldVertex drawn_vertex(const HeightField& field, std::int64_t i, std::int64_t j);

}  // namespace touchable
