// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Planar depth in millimetres at a pixel, at a time in seconds.
using TrueDepth = std::function<double(double x, double y, double t)>;

/// Scene of a structured-light camera: 320x240 pixels, codes in millimetres, 30 frames a second; its stated
/// noise is that of `noisy_frame`, fitted at the depths in this scene.
Scene noisy_scene();
/// A leaning wall 1.2 m away, and in front of it a ball of 15 cm radius that moves back and forth at up to
/// 0.57 m/s sideways and 0.19 m/s in depth.
double ball_and_wall(double x, double y, double t);

/// A number with mean 0 and variance 1: the sum of 12 uniform numbers, nearly normal.
double normal(SplitMix64& random);
/// Standard deviation at a depth: 1.2 + 1.9 (z - 0.4)^2 mm, z in metres (Kinect, first generation; Khoshelham
/// and Elberink 2012).
double camera_noise(double depth);
/// width x height numbers of variance 1, row-major, each made from four values that neighbours use too:
/// adjacent numbers share half.
std::vector<double> shared_noise(int width, int height, SplitMix64& random);
/// Frame `number` of the camera's picture of a scene: noise half shared by neighbours, at silhouettes of more
/// than 50 mm three of ten pixels between near and far, and twelve blobs without depth. The same bits on
/// every machine.
RawFrame noisy_frame(const Scene& scene, const TrueDepth& truth, std::int64_t number);

}  // namespace touchable
