#include "bench/surface/opencv_median.hpp"

#ifdef TOUCHABLE_HAS_OPENCV
#include <opencv2/imgproc.hpp>
#endif

namespace touchable {

#ifdef TOUCHABLE_HAS_OPENCV

bool has_opencv() {
    return true;
}

void opencv_median(const PlaneView& from, int side, std::uint8_t* to, std::ptrdiff_t to_stride) {
    const int type = from.bytes_per_sample == 2 ? CV_16UC1 : CV_8UC1;
    // OpenCV's headers know no read-only picture.
    const cv::Mat source(from.height, from.width, type, const_cast<std::uint8_t*>(from.data),
                         static_cast<std::size_t>(from.stride));
    cv::Mat filtered(from.height, from.width, type, to, static_cast<std::size_t>(to_stride));
    cv::medianBlur(source, filtered, side);
}

#else

bool has_opencv() {
    return false;
}

void opencv_median(const PlaneView&, int, std::uint8_t*, std::ptrdiff_t) {}

#endif

}  // namespace touchable
