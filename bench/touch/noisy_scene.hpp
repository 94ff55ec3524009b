#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Planar depth in millimetres of whatever is seen at a pixel, at a time in seconds.
using TrueDepth = std::function<double(double x, double y, double t)>;

/// A structured-light camera of 320x240 pixels, millimetres as codes, 30 frames a second; the noise that its
/// scene states is that of `noisy_frame`, fitted at the depths that are seen here.
Scene noisy_scene();
/// A wall 1.2 m away that leans, and before it a ball of 15 cm that goes to and fro at up to 0.57 m/s
/// sideways and 0.19 m/s in depth.
double ball_and_wall(double x, double y, double t);

/// Of mean 0 and variance 1: the sum of 12 uniform numbers, which is normal enough.
double normal(SplitMix64& random);
/// Standard deviation at a depth: 1.2 + 1.9 (z - 0.4)^2 mm, z in metres (Kinect of the first kind; Khoshelham
/// and Elberink 2012).
double camera_noise(double depth);
/// width x height numbers of variance 1, row-major, each made of four that its neighbours take part in too:
/// those beside each other share half.
std::vector<double> shared_noise(int width, int height, SplitMix64& random);
/// Frame `number` of what the camera makes of a scene: noise that neighbours share half of, at silhouettes of
/// more than 50 mm three pixels of ten anywhere between near and far, and twelve blobs without depth. The
/// same bits everywhere.
RawFrame noisy_frame(const Scene& scene, const TrueDepth& truth, std::int64_t number);

}  // namespace touchable
