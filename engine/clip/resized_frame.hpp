#pragma once

#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Of each column (or row) of a picture of `to` the one that its sample is taken from: the nearest to where
/// its middle lies in a picture of `from`.
std::vector<int> nearest_samples(int from, int to);

/// The scene of its pictures at another size. Focal lengths scale; the principal point lies so that samples
/// taken by `nearest_samples` unproject to where they were: exactly, where `from` is a whole multiple of
/// `to`, otherwise up to half a pixel of the larger picture beside it, and on average at their place.
Scene resized_scene(Scene scene, int width, int height);

/// A frame at the size of that scene. Of depth, haptic and height each pixel is a sample as it was, never a
/// mixture: what lies between the two sides of a silhouette is nothing. Colour is the mean of what a pixel
/// covers.
RawFrame resized_frame(const RawFrame& frame, int width, int height);

}  // namespace touchable
