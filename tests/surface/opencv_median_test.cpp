#include <gtest/gtest.h>

#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"

#ifdef TOUCHABLE_HAS_OPENCV
#include <opencv2/imgproc.hpp>
#endif

namespace touchable::test {
namespace {

#ifdef TOUCHABLE_HAS_OPENCV

/// The first difference of two pictures, or nothing.
std::string first_difference_of(const cv::Mat& expected, const SurfaceFrame& frame, int bits) {
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) {
            const int value = bits == 8 ? expected.at<std::uint8_t>(y, x) : expected.at<std::uint16_t>(y, x);
            const int code = frame.codes[frame.index(x, y)];
            if (value != code)
                return "pixel " + std::to_string(x) + ", " + std::to_string(y) + ": " + std::to_string(code) +
                       ", OpenCV's " + std::to_string(value);
        }
    return {};
}

/// OpenCV repeats the border as we do; of holes it knows nothing.
TEST(MedianFilter, MatchesOpenCvIncludingBorders) {
    Random random(11);
    int pictures = 0, changed = 0;
    for (const auto& [width, height] :
         {std::pair{5, 5}, {31, 7}, {32, 32}, {33, 18}, {64, 3}, {97, 61}, {640, 80}})
        for (const int bits : {8, 16})
            for (const int side : {3, 5})
                for (const Fill fill : {Fill::random, Fill::extremes, Fill::few_values, Fill::ramp}) {
                    const Scene scene = depth_scene(width, height, bits, Marking::none, {side, 0});
                    const StoredPlane plane = store_plane(width, height, fill_picture(scene, fill, random),
                                                          {.bytes_per_sample = bits / 8});
                    SurfaceFrame frame;
                    ASSERT_TRUE(make_cpu_builder(scene)->build(plane.frame(), frame));
                    const cv::Mat stored(height, width, bits == 8 ? CV_8UC1 : CV_16UC1,
                                         const_cast<std::uint8_t*>(plane.view.data),
                                         static_cast<std::size_t>(plane.view.stride));
                    cv::Mat filtered;
                    cv::medianBlur(stored, filtered, side);
                    ASSERT_EQ(first_difference_of(filtered, frame, bits), "")
                        << width << "x" << height << ", " << bits << " bits, median " << side << ", fill "
                        << static_cast<int>(fill);
                    ++pictures;
                    changed += cv::norm(stored, filtered, cv::NORM_INF) > 0 ? 1 : 0;
                }
    EXPECT_GT(changed, pictures / 2);
}

#else

TEST(MedianFilter, MatchesOpenCvIncludingBorders) {
    GTEST_SKIP() << "built without OpenCV (Debian: libopencv-imgproc-dev)";
}

#endif

}  // namespace
}  // namespace touchable::test
