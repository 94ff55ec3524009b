// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A guess at the paper's natural content (docs/paper.md): a person's chest 1 m in front of a depth camera of
/// 320x240 pixels and 8 bits, 30 frames a second. Camera and planes are from the paper's Fig. 9, read as
/// millimetres on the sensor and centimetres in front of it. Scene units are centimetres.
Scene chest_scene();
/// Range to an upright ellipsoid (24 cm deep, 40 cm wide, 70 cm high), or to the wall behind it.
double chest_range(const Camera& camera, double x, double y);

/// Frame `number` as seen by the camera: noise with that standard deviation in levels, independent per pixel
/// and frame, as of a time-of-flight camera; then rounded to levels. The same bits on every machine.
RawFrame noisy_chest_frame(const Scene& scene, double noise_levels, std::int64_t number);

}  // namespace touchable
