// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/opencv_pipeline.hpp"

#include <algorithm>

#include "engine/scene/frames.hpp"
#include "shaders/cut_rule.h"

#ifdef TOUCHABLE_HAS_OPENCV
#include <opencv2/imgproc.hpp>
#endif

namespace touchable {

OpenCvPipeline::OpenCvPipeline(const Scene& scene, const RawFrame& raw)
    : width_(scene.width),
      height_(scene.height),
      side_(scene.filter.median),
      raw_(raw),
      per_code_((scene.depth.near - scene.depth.far) / scene.depth.code_max),
      of_code_0_(scene.depth.far) {
    if (!has_opencv()) return;
    const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    filtered_.resize(pixels * static_cast<std::size_t>(raw.depth.bytes_per_sample));
    depth_.resize(pixels);
    q_.resize(pixels);
    const TileGrid grid = TileGrid::of(width_, height_);
    marks_.resize(static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y));
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x)
            ray_lengths_.push_back(static_cast<float>(scene.camera.ray_length(x, y)));
}

PlaneView OpenCvPipeline::codes() const {
    const int bytes = raw_.depth.bytes_per_sample;
    return {filtered_.data(), std::ptrdiff_t{width_} * bytes, width_, height_, bytes, 1};
}

void OpenCvPipeline::mark_cuts() {
    const TileGrid grid = TileGrid::of(width_, height_);
    std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
    for (int y = 0; y + 1 < height_; ++y) {
        const float* upper = q_.data() + std::ptrdiff_t{y} * width_;
        const float* lower = upper + width_;
        std::uint8_t* marks = marks_.data() + std::ptrdiff_t{y / TileGrid::cells} * grid.tiles_x;
        for (int x = 0; x + 1 < width_; ++x) {
            const bool right = triangle_is_cut(upper[x], upper[x + 1], lower[x + 1]);
            const bool left = triangle_is_cut(upper[x], lower[x + 1], lower[x]);
            marks[x / TileGrid::cells] |= static_cast<std::uint8_t>((right || left) + 2 * !(right && left));
        }
    }
}

#ifdef TOUCHABLE_HAS_OPENCV

bool has_opencv() {
    return true;
}

namespace {

/// OpenCV has no read-only picture.
cv::Mat matrix_of(const PlaneView& plane) {
    return {plane.height, plane.width, plane.bytes_per_sample == 2 ? CV_16UC1 : CV_8UC1,
            const_cast<std::uint8_t*>(plane.data), static_cast<std::size_t>(plane.stride)};
}
cv::Mat matrix_of(std::vector<float>& values, int width, int height) {
    return {height, width, CV_32FC1, values.data()};
}

}  // namespace

void OpenCvPipeline::median() {
    cv::Mat filtered = matrix_of(codes());
    cv::medianBlur(matrix_of(raw_.depth), filtered, side_);
}

void OpenCvPipeline::take_depth() {
    cv::Mat depth = matrix_of(depth_, width_, height_);
    matrix_of(codes()).convertTo(depth, CV_32F, per_code_, of_code_0_);
}

void OpenCvPipeline::q() {
    take_depth();
    cv::Mat q = matrix_of(q_, width_, height_);
    cv::divide(matrix_of(ray_lengths_, width_, height_), matrix_of(depth_, width_, height_), q);
}

void opencv_bilateral(std::vector<float>& picture, int width, int height, int side, double sigma,
                      double sigma_px) {
    const cv::Mat from = matrix_of(picture, width, height).clone();
    cv::Mat to = matrix_of(picture, width, height);
    cv::bilateralFilter(from, to, side, sigma, sigma_px);
    for (int y = 0; y < height; ++y)  // holes stay
        for (int x = 0; x < width; ++x)
            if (from.at<float>(y, x) == 0) to.at<float>(y, x) = 0;
}

#else

void opencv_bilateral(std::vector<float>&, int, int, int, double, double) {}
bool has_opencv() {
    return false;
}

void OpenCvPipeline::median() {}
void OpenCvPipeline::take_depth() {}
void OpenCvPipeline::q() {}

#endif

}  // namespace touchable
