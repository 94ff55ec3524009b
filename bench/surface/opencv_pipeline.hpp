// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Whether this program was built with OpenCV.
bool has_opencv();

/// A typical OpenCV implementation for a frame of linear depth without invalid pixels: its median, its matrix
/// operations for depth, and the remaining lines of C++. Call the steps in order. Does nothing without
/// OpenCV.
class OpenCvPipeline {
public:
    /// The median's side is the scene's: 3 or 5. `raw` must outlive this.
    OpenCvPipeline(const Scene& scene, const RawFrame& raw);

    void median();     ///< filters stored values; OpenCV's median has one thread
    void q();          ///< 1 / planar depth, with a precomputed plane of ray lengths
    void mark_cuts();  ///< per tile: whether a triangle is cut, and whether one is not

    PlaneView codes() const;
    const std::vector<float>& q_plane() const { return q_; }
    /// 1: some triangle is cut, 2: some is not; by tile of TileGrid, row by row.
    const std::vector<std::uint8_t>& cut_marks() const { return marks_; }

private:
    void take_depth();

    const int width_, height_, side_;
    const RawFrame& raw_;
    std::vector<std::uint8_t> filtered_;
    std::vector<float> depth_, q_, ray_lengths_;
    std::vector<std::uint8_t> marks_;
    double per_code_, of_code_0_;  // depth, linear in the code
};

/// OpenCV's bilateral filter, in place. `sigma`: of samples; `sigma_px`: of places. Nothing without OpenCV.
void opencv_bilateral(std::vector<float>& picture, int width, int height, int side, double sigma,
                      double sigma_px);

}  // namespace touchable
