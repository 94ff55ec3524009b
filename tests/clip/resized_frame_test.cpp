// Pictures at another size: what is touched is never mixed, and stays where it was.
#include "engine/clip/clip.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

/// Columns of a picture by whose middle a pixel of another lies, in plain words.
int nearest_in_long_double(int k, int from, int to) {
    const long double middle = (k + 0.5L) * from / to;  // of the pixel, in the other picture's pixels
    return static_cast<int>(std::floor(middle + 1e-12L));
}

TEST(ResizedFrame, TouchIsMadeOfSamplesAsTheyWere) {
    const Scene scene = small_scene(30, 20, 12);
    const RawFrame frame = test_frame(scene, 3, all_planes);
    for (const auto& [width, height] : {std::pair{15, 10}, {10, 4}, {7, 13}, {60, 20}, {1, 1}}) {
        const RawFrame small = resized_frame(frame, width, height);
        EXPECT_EQ(small.number, 3);
        EXPECT_EQ(small.time_ns, frame.time_ns);
        for (const PlaneRole role : {PlaneRole::depth, PlaneRole::haptic, PlaneRole::height}) {
            const PlaneView &was = plane_of(frame, role), &is = plane_of(small, role);
            ASSERT_EQ(is.width, width);
            ASSERT_EQ(is.height, height);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    for (int channel = 0; channel < was.channels; ++channel)
                        ASSERT_EQ(is.sample(x, y, channel),
                                  was.sample(nearest_in_long_double(x, 30, width),
                                             nearest_in_long_double(y, 20, height), channel));
        }
    }
}

TEST(ResizedFrame, ColourIsTheMeanOfWhatAPixelCovers) {
    const Scene scene = small_scene(12, 9);
    const RawFrame frame = test_frame(scene, 1, {true, false, false});
    for (const auto& [width, height] : {std::pair{4, 3}, {5, 7}, {12, 9}, {24, 10}}) {
        const RawFrame small = resized_frame(frame, width, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                // By 0.1 of a percent of a pixel on each side.
                long double sum = 0, weight = 0;
                const auto overlap = [](int s, int k, int from, int to) {
                    const long double begin = static_cast<long double>(k) * from / to,
                                      end = static_cast<long double>(k + 1) * from / to;
                    return std::max(0.0L,
                                    std::min<long double>(end, s + 1) - std::max<long double>(begin, s));
                };
                for (int v = 0; v < 9; ++v)
                    for (int u = 0; u < 12; ++u) {
                        const long double share = overlap(u, x, 12, width) * overlap(v, y, 9, height);
                        sum += share * frame.colour.sample(u, v, 1);
                        weight += share;
                    }
                EXPECT_LE(std::fabs(small.colour.sample(x, y, 1) - sum / weight), 0.5L + 1e-9L);
            }
    }
}

/// Each sample of depth where it was in the world: to the last bits where pixels are left out evenly.
TEST(ResizedFrame, VerticesStayWhereTheyWere) {
    Scene scene = small_scene(30, 20);
    scene.camera = {51.25, 49.5, 14.3, 9.7};
    for (const auto& [width, height] : {std::pair{15, 10}, {10, 4}, {6, 5}, {30, 20}}) {
        const Camera camera = resized_scene(scene, width, height).camera;
        const std::vector<int> columns = nearest_samples(30, width), rows = nearest_samples(20, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double i = columns[static_cast<std::size_t>(x)], j = rows[static_cast<std::size_t>(y)];
                EXPECT_NEAR(camera.u(x), scene.camera.u(i), 1e-14);
                EXPECT_NEAR(camera.v(y), scene.camera.v(j), 1e-14);
            }
    }
    // Elsewhere within half a pixel of the larger picture, and on average where it was.
    for (const int width : {7, 11, 29, 45, 64}) {
        const Camera camera = resized_scene(scene, width, 20).camera;
        const std::vector<int> columns = nearest_samples(30, width);
        double sum = 0;
        for (int x = 0; x < width; ++x) {
            const double off = (camera.u(x) - scene.camera.u(columns[static_cast<std::size_t>(x)])) * 51.25;
            EXPECT_LE(std::fabs(off), 0.5) << width;
            sum += off;
        }
        EXPECT_NEAR(sum, 0, 1e-10) << width;
    }
}

}  // namespace
}  // namespace touchable::test
