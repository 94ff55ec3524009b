// SPDX-License-Identifier: Apache-2.0
#pragma once

// The surfaces of a recording, told apart by colour and depth and followed through time.
//
// A frame is divided into superpixels by its PixelFeatures, similar ones are merged to regions, small regions
// are cleaned away, and labels are kept from frame to frame (regions.hpp).

#include "engine/authoring/segments.hpp"
#include "engine/base/threads.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Features that tell pixels apart, in numbers of which equal differences weigh about the same: 4 units are
/// one level of 255 of colour, or 0.07 % of the depth.
struct PixelFeatures {
    static constexpr std::int32_t no_surface = -(1 << 20);
    static constexpr int depth_per_octave = 4096;

    int width = 0, height = 0;
    /// Of a mean over 3x3 pixels. Brightness, which shading changes, has half the weight; the two of hue are
    /// shares of the brightness, which shading does not change.
    std::vector<std::int16_t> brightness, red_green, yellow_blue;
    /// Logarithm of the planar depth, so that a share of it is a difference; `no_surface` in holes.
    std::vector<std::int32_t> depth;

    std::size_t place(int x, int y) const { return pixel_place(x, y, width); }
    bool has_surface(std::size_t k) const { return depth[k] != no_surface; }
};

inline std::int64_t squared(std::int64_t difference) {
    return difference * difference;
}

class FeatureReader {
public:
    explicit FeatureReader(const Scene& scene);
    void read(const RawFrame& frame, PixelFeatures& features, RowBands& bands) const;
    /// Difference from one code to the next, around this depth.
    std::int32_t quantum(std::int32_t depth) const;

private:
    void read_colour(const PlaneView& colour, PixelFeatures& features, const RowBand& band) const;
    void read_depth(const PlaneView& depth, PixelFeatures& features, const RowBand& band) const;

    int width_, height_;
    DepthCoding coding_;
    std::vector<std::int32_t> depth_of_code_, ray_;  // ray_: by pixel, for range depth; else empty
    std::vector<std::int32_t> quanta_;               // by eighths of an octave
    std::vector<std::int32_t> shares_;
};

/// Follows segments through a clip, whose frames are given in order. `threads`: 0: as many as pay. Integers
/// throughout: the same frames have the same labels on every machine, with any number of threads.
SegmentFrames follow_segments(const Scene& scene, int threads = 0);

}  // namespace touchable
