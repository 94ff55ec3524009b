// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/content/made_maps.hpp"

// Generated scenes and strokes are the same bits on every compiler, optimisation level and machine: these
// sums were taken once and change only when a scene is changed on purpose.
namespace touchable::test {
namespace {

class Sum : public ByteHash {
public:
    using ByteHash::add;
    void add(const PlaneView& plane) {
        if (plane.empty()) return;
        for (int y = 0; y < plane.height; ++y) add(plane.row(y), static_cast<std::size_t>(plane.stride));
    }
    void add(double value) { add(&value, sizeof value); }
    void add(const glm::dvec3& value) {
        for (int axis = 0; axis < 3; ++axis) add(value[axis]);
    }
};

std::uint64_t sum_of(std::string_view name, bool properties) {
    SceneOptions options = sized(96, 64);
    options.properties = properties;
    const auto scene = made(name, options);
    const ExactSurface exact(name, options);
    Sum sum;
    for (const std::int64_t n : {0, 7}) {
        const RawFrame frame = scene->frame(n);
        for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
            sum.add(*plane);
        for (int y = 0; y < 64; y += 5)
            for (int x = 0; x < 96; x += 5) {
                sum.add(scene->depth(x, y, scene->time_of(n)));
                const glm::dvec3 at = seen(*scene, x, y, scene->time_of(n));
                const auto truth = exact.closest(at * 1.003, at, scene->time_of(n));
                if (truth) sum.add(truth->point);
            }
    }
    return sum.value();
}

TEST(GoldenSums, MatchScenes) {
    const std::map<std::string, std::uint64_t> expected{
        {"globe", 0x4f77d42536996ca0U},  {"bumps", 0x65a51477c046e06dU}, {"rough", 0x976a1fadbde4589cU},
        {"moving", 0xb2e4e26096ada87cU}, {"plane", 0xf190a6efff15d4afU}, {"spheres", 0x8537fbe08ba07457U},
        {"step", 0x74dc69c743c79423U},   {"noise", 0x106f99cfe9b9cb2cU}, {"cliffs", 0x10df5adf54c1bb64U},
        {"grain", 0x284308bed1be2994U},
    };
    for (const std::string_view name : scene_names())
        EXPECT_EQ(sum_of(name, false), expected.at(std::string(name)))
            << name << std::hex << " 0x" << sum_of(name, false);
    EXPECT_EQ(sum_of("globe", true), 0x5b33ac730605322eU) << std::hex << " 0x" << sum_of("globe", true);
}

TEST(GoldenSums, MatchStrokes) {
    Sum globe, relief, walk;
    const GlobeStroke globe_stroke(CameraPreset::b, 720, 480);
    for (int tick = 0; tick < 20200; tick += 3) globe.add(globe_stroke.at(tick).goal);
    ReliefStroke relief_stroke(Relief::moving, 320, 240, 0.3);
    for (int tick = 0; tick < 5000; ++tick) relief.add(relief_stroke.next().goal);
    RandomWalk random_walk(made("noise", sized(128, 128))->scene(), 1);
    for (int tick = 0; tick < 5000; ++tick) walk.add(random_walk.next());
    EXPECT_EQ(globe.value(), 0x6b337d79d04d9838U) << std::hex << "0x" << globe.value();
    EXPECT_EQ(relief.value(), 0xcbe49dade3fbd064U) << std::hex << "0x" << relief.value();
    EXPECT_EQ(walk.value(), 0xf9b97d027a70849fU) << std::hex << "0x" << walk.value();
}

}  // namespace
}  // namespace touchable::test
