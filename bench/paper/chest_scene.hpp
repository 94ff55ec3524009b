#pragma once

#include <cstdint>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What the paper's natural content may have been (docs/paper.md): a person's chest 1 m before a depth camera
/// of 320x240 pixels and 8 bits, 30 frames a second. Camera and planes are those of the paper's Fig. 9, read
/// as millimetres on the sensor and centimetres before it. Scene units are centimetres.
Scene chest_scene();
/// Range to an upright ellipsoid (half as deep as a person is, 40 cm wide, 70 cm high), or to the wall
/// behind.
double chest_range(const Camera& camera, double x, double y);

/// Frame `number` as the camera sees it: noise of that standard deviation in levels, each pixel and frame for
/// itself, as of a camera that measures time of flight; then rounded to levels. The same bits everywhere.
RawFrame noisy_chest_frame(const Scene& scene, double noise_levels, std::int64_t number);

}  // namespace touchable
