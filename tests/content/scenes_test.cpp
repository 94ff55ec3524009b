#include "engine/content/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/content/made.hpp"

namespace touchable {
namespace {

std::string refusal(std::string_view name, const SceneOptions& options) {
    const auto scene = make_scene(name, options);
    return scene ? "" : scene.error().message;
}

TEST(Scenes, UnknownNameIsRefusedWithTheKnownOnes) {
    const auto scene = make_scene("glob", {});
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().kind, ErrorKind::usage);
    for (const std::string_view name : scene_names())
        EXPECT_NE(scene.error().message.find(name), std::string::npos) << name;
}

TEST(Scenes, ImpossibleOptionsAreRefusedByNumber) {
    EXPECT_NE(refusal("bumps", sized(720, 480, 7)).find("7 bits"), std::string::npos);
    EXPECT_NE(refusal("bumps", sized(720, 480, 17)).find("17 bits"), std::string::npos);
    for (const std::string_view name : scene_names()) {
        EXPECT_NE(refusal(name, sized(0, 480)).find("0x480"), std::string::npos) << name;
        EXPECT_NE(refusal(name, sized(720, 16385)).find("720x16385"), std::string::npos) << name;
        EXPECT_NE(refusal(name, sized(-5, -5)).find("-5x-5"), std::string::npos) << name;
    }
    EXPECT_NE(refusal("globe", sized(100, 200)).find("too tall"), std::string::npos);
    EXPECT_NE(refusal("rough", sized(100, 401)).find("too tall"), std::string::npos);
    EXPECT_NE(refusal("step", sized(21, 21)).find("21"), std::string::npos);
    for (const double tilt : {-1.0, 60.5, std::nan("")}) {
        SceneOptions options;
        options.tilt_degrees = tilt;
        EXPECT_NE(refusal("plane", options).find("tilt"), std::string::npos) << tilt;
    }
    SceneOptions properties;
    properties.properties = true;
    EXPECT_NE(refusal("bumps", properties).find("globe"), std::string::npos);
}

TEST(Scenes, EveryNameMakesAValidSceneOfTheAskedSizeAndBits) {
    for (const std::string_view name : scene_names())
        for (const int bits : {8, 10, 12, 16}) {
            const auto scene = made(name, sized(96, 64, bits));
            ASSERT_TRUE(scene);
            EXPECT_TRUE(validate(scene->scene())) << name;
            EXPECT_EQ(scene->scene().name, name);
            EXPECT_EQ(scene->scene().depth.code_max, (1 << bits) - 1);
            const RawFrame frame = scene->frame(2);
            EXPECT_EQ(frame.number, 2);
            EXPECT_EQ(frame.time_ns, 66666666);
            ASSERT_EQ(frame.depth.width, 96);
            ASSERT_EQ(frame.depth.height, 64);
            EXPECT_EQ(frame.depth.bytes_per_sample, bits == 8 ? 1 : 2);
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 96; ++x)
                    ASSERT_TRUE(scene->scene().depth.is_valid(frame.depth.sample(x, y)))
                        << name << " " << x << " " << y;
        }
}

TEST(Scenes, CodesAreWithinHalfACodeOfTheAnalyticDepth) {
    for (const std::string_view name : scene_names())
        for (const int bits : {8, 10, 16}) {
            const auto scene = made(name, sized(90, 60, bits));
            const DepthCoding& coding = scene->scene().depth;
            const double step = (coding.far - coding.near) / coding.code_max;
            const RawFrame frame = scene->frame(17);
            for (int y = 0; y < 60; ++y)
                for (int x = 0; x < 90; ++x) {
                    const double depth = scene->depth(x, y, scene->time_of(17));
                    ASSERT_LE(depth, coding.far) << name;
                    ASSERT_GE(depth, coding.near) << name;
                    ASSERT_LE(std::fabs(coding.depth(frame.depth.sample(x, y)) - depth), step * (0.5 + 1e-9))
                        << name;
                }
        }
}

TEST(Scenes, ExactFrameHoldsTheAnalyticDepthAndTheTouchPlanes) {
    SceneOptions options = sized(75, 50);
    options.properties = true;
    const auto scene = made("globe", options);
    SurfaceFrame exact;
    exact.codes.assign(3, 7);  // of a slot used before
    scene->exact_frame(40, exact);
    const RawFrame frame = scene->frame(40);
    EXPECT_TRUE(exact.codes.empty());
    EXPECT_TRUE(exact.tiles.empty());
    EXPECT_EQ(exact.coding, scene->scene().depth);
    ASSERT_EQ(exact.haptic.size(), 75U * 50U * 3U);
    ASSERT_EQ(exact.heights.size(), 75U * 50U);
    for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 75; ++x) {
            ASSERT_TRUE(exact.is_valid(x, y));
            const DepthSample sample = exact.vertices->at(x, y);
            ASSERT_TRUE(sample.valid);
            ASSERT_EQ(sample.depth, scene->depth(x, y, scene->time_of(40)));
            ASSERT_EQ(exact.heights[exact.index(x, y)], frame.height.sample(x, y));
            ASSERT_EQ(exact.haptic[3 * exact.index(x, y) + 1], frame.haptic.sample(x, y, 1));
        }
}

TEST(Scenes, FramesComeAtTheAskedRate) {
    SceneOptions options = sized(64, 48);
    options.rate = {30000, 1001};
    const auto scene = made("moving", options);
    EXPECT_EQ(scene->scene().rate.num, 30000);
    EXPECT_EQ(scene->frame(30000).time_ns, 1001'000'000'000);
    EXPECT_DOUBLE_EQ(scene->time_of(30000), 1001);
    EXPECT_EQ(scene->frame(3).depth.sample(40, 20),
              scene->scene().depth.code(scene->depth(40, 20, 3 * 1001.0 / 30000)));
}

/// All bytes of a frame, plane after plane.
std::string bytes_of(const RawFrame& frame) {
    std::string bytes;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        for (int y = 0; y < plane->height; ++y)
            bytes.append(reinterpret_cast<const char*>(plane->row(y)),
                         static_cast<std::size_t>(plane->stride));
    return bytes;
}

TEST(Scenes, ThreadsThatShareTheRowsChangeNoBit) {
    for (const std::string_view name : scene_names()) {
        SceneOptions options = sized(75, 151, name == "step" ? 8 : 16);
        if (name == "globe") options = sized(150, 101);
        options.properties = name == "globe";
        options.threads = 1;
        const std::string alone = bytes_of(made(name, options)->frame(5));
        for (const int threads : {2, 3, 7}) {
            options.threads = threads;
            EXPECT_TRUE(bytes_of(made(name, options)->frame(5)) == alone) << name << ", " << threads;
        }
    }
}

TEST(Scenes, FramesOutliveTheSceneThatMadeThem) {
    auto scene = made("bumps", sized(20, 20));
    const std::uint16_t code = scene->frame(0).depth.sample(3, 4);
    const RawFrame frame = scene->frame(5);
    scene.reset();
    EXPECT_EQ(frame.depth.sample(3, 4), code);
}

}  // namespace
}  // namespace touchable
