// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {

/// A depth plane with its own memory, laid out as awkwardly as a decoder may.
struct StoredPlane {
    std::vector<std::uint8_t> memory;
    PlaneView view;

    RawFrame frame() const {
        RawFrame raw;
        raw.depth = view;
        return raw;
    }
};

struct Layout {
    int bytes_per_sample = 2;
    int padding = 0;         ///< bytes between the end of a row and the next one; odd ones misalign samples
    bool bottom_up = false;  ///< negative stride
};

/// `values`: width x height, row-major.
StoredPlane store_plane(int width, int height, const std::vector<std::uint16_t>& values,
                        const Layout& layout);

/// How a clip may mark its invalid pixels.
enum class Marking {
    zero,           ///< code 0, as depth cameras do
    range_and_few,  ///< codes beyond near and far, and a few in between; code 0 too
    largest,        ///< the largest code, so that 0 is a valid code; of logarithmic depth
    none,           ///< every code is valid
};
inline constexpr Marking all_markings[] = {Marking::zero, Marking::range_and_few, Marking::largest,
                                           Marking::none};

/// A scene of depth pictures only.
Scene depth_scene(int width, int height, int bits, Marking marking, FilterSettings filter = {});

/// Planar depth in 16-bit codes of `scale` units each, up to `far`; code 0 is invalid.
Scene metric_scene(int width, int height, const Camera& camera, double far, double scale = 1);

/// Pictures that make filters stumble.
enum class Fill {
    all_least,
    all_greatest,
    random,
    extremes,    ///< least and greatest valid code at random
    few_values,  ///< many ties
    ramp,
    stripes,       ///< of valid and invalid columns
    rows,          ///< of valid and invalid rows
    checkerboard,  ///< of valid and invalid pixels
    all_invalid,
    single_valid,
    single_invalid,
    invalid_border,
    few_holes,
    half_holes,
    many_holes,
    blob,          ///< one large hole in a noisy slope
    silhouettes,   ///< flat patches of a few depths, and pixels in between
    slanted_edges  ///< flat patches, and ramps of 1 to 15 pixels from one to the next
};
inline constexpr int fill_count = static_cast<int>(Fill::slanted_edges) + 1;

std::vector<std::uint16_t> fill_picture(const Scene& scene, Fill fill, Random& random);
/// The picture of this seed, stored without padding.
StoredPlane noisy_plane(const Scene& scene, Fill fill, std::uint64_t seed);

/// A sum of 12 uniform numbers: about normal, of mean 0 and variance 1.
template <class Uniform>
double normal(Uniform&& uniform) {
    double sum = -6;
    for (int n = 0; n < 12; ++n) sum += uniform();
    return sum;
}

/// The first difference of two frames, bit for bit, or nothing.
std::string first_difference(const SurfaceFrame& expected, const SurfaceFrame& actual);

/// The first difference from what the reference builder makes of a frame, or nothing.
std::string reference_difference(const Scene& scene, const RawFrame& raw, const SurfaceFrame& actual);

/// The first vertex that differs from an expected frame's codes, or nothing.
std::string first_vertex_difference(const SurfaceFrame& expected, const VertexSource& actual);

/// The first tile whose bounds leave out a depth of the expected frame, or nothing.
std::string first_tile_not_enclosed(const SurfaceFrame& expected, const VertexSource& actual);

}  // namespace touchable::test
