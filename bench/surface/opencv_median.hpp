#pragma once

#include "engine/frame/plane_view.hpp"

namespace touchable {

/// Whether this program was built with OpenCV.
bool has_opencv();

/// cv::medianBlur with `side` 3 or 5, of a plane of one channel and contiguous or padded rows, into another
/// of the same form whose memory may be written. On one thread: OpenCV's median has no more. Does nothing
/// without OpenCV.
void opencv_median(const PlaneView& from, int side, std::uint8_t* to, std::ptrdiff_t to_stride);

}  // namespace touchable
