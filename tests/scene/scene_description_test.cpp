#include "engine/scene/scene.hpp"

#include <gtest/gtest.h>

#include "tests/scene/scene_texts.hpp"

namespace touchable {
namespace {

SceneDescription of_millimetres(const std::string& more = {}) {
    return described(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "depth": {"coding": "metric", "scale": 0.001}, "folder": {"depth": "d%d.png", "cameras": "k%d.json"})" +
                     more + "}");
}

SceneDescription::FoundInClip all_found() {
    return {.rate = FrameRate{25, 1}, .camera = Camera{5, 6, 1, 2}, .far = 2.5};
}

TEST(SceneDescription, TakesWhatIsOpenFromTheClip) {
    const SceneDescription open = of_millimetres();
    EXPECT_EQ(open.unstated, (SceneDescription::Unstated{true, true, true, all_unstated}));
    const auto scene = settle(open, all_found());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->rate.num, 25);
    EXPECT_EQ(scene->camera, (Camera{5, 6, 1, 2}));
    EXPECT_EQ(scene->depth.far, 2.5);
    EXPECT_EQ(scene->depth.valid_max, 2500) << "what lies beyond is no depth";
    EXPECT_TRUE(validate(*scene));
}

TEST(SceneDescription, KeepsWhatIsStated) {
    SceneDescription stated = parsed(recording);
    EXPECT_EQ(stated.unstated, SceneDescription::Unstated{});
    const auto scene = settle(stated, all_found());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene_to_json(*scene), scene_to_json(stated));
}

TEST(SceneDescription, HasDefaultsOfRateAndFarButNotOfTheCamera) {
    SceneDescription::FoundInClip camera_alone;
    camera_alone.camera = Camera{5, 6, 1, 2};
    const auto scene = settle(of_millimetres(), camera_alone);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->rate.num, 30);
    EXPECT_EQ(scene->depth.valid_max, 65535);
    const auto none = settle(of_millimetres(), {.rate = FrameRate{25, 1}, .far = 2.5});
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message.find("camera is missing: must be given"), std::string::npos);
}

// Whether levels leave room for finer codes is known with the far plane.
TEST(SceneDescription, TerraceRemovalIsJudgedWithTheFarPlane) {
    const SceneDescription open = of_millimetres(R"(, "filter": {"terraces": "on", "levels": [0, 30]})");
    SceneDescription::FoundInClip found = all_found();
    EXPECT_TRUE(settle(open, found));
    found.far = 60;
    const auto too_far = settle(open, found);
    ASSERT_FALSE(too_far);
    EXPECT_NE(too_far.error().message.find("filter.terraces is on"), std::string::npos);
    found.far = 1e-9;
    EXPECT_FALSE(settle(open, found)) << "no code is so near";
}

}  // namespace
}  // namespace touchable
