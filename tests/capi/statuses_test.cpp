// What the C API refuses, and how it says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/capi/hill.hpp"

namespace touchable::test {
namespace {

touch_error no_error() {
    return {sizeof(touch_error), 0, {}};
}

TEST(Statuses, HaveNames) {
    EXPECT_EQ(touch_version(), static_cast<std::uint32_t>(TOUCH_VERSION));
    EXPECT_STREQ(touch_status_name(TOUCH_STALE), "stale handle");
    EXPECT_STREQ(touch_status_name(12345), "unknown status");
}

TEST(Statuses, HandlesOfOthersAndOfTheDeadAreStale) {
    touch_scene scene{};
    const touch_camera camera = Hill::camera();
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    touch_surface surface{};
    ASSERT_EQ(touch_surface_create(scene, nullptr, &surface, nullptr), TOUCH_OK);
    touch_error error = no_error();
    touch_solver solver{};
    EXPECT_EQ(touch_solver_create({scene.id}, nullptr, &solver, &error), TOUCH_STALE);
    EXPECT_NE(std::string(error.line).find("surface"), std::string::npos) << error.line;
    EXPECT_EQ(touch_surface_destroy({scene.id}), TOUCH_STALE);
    EXPECT_EQ(touch_scene_destroy({surface.id}), TOUCH_STALE);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_STALE);
    touch_scene next{};
    ASSERT_EQ(touch_scene_from_camera(&camera, &next, nullptr), TOUCH_OK);
    EXPECT_NE(next.id, scene.id) << "a place that is used again is another object";
    EXPECT_EQ(touch_scene_destroy(next), TOUCH_OK);
    EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
}

TEST(Statuses, OneSolverForASurfaceWhichOutlastsIt) {
    TouchedHill hill;
    touch_solver second{};
    EXPECT_EQ(touch_solver_create(hill.surface, nullptr, &second, nullptr), TOUCH_BUSY);
    EXPECT_EQ(touch_surface_destroy(hill.surface), TOUCH_BUSY);
    EXPECT_EQ(touch_solver_destroy(hill.solver), TOUCH_OK);
    EXPECT_EQ(touch_solver_create(hill.surface, nullptr, &hill.solver, nullptr), TOUCH_OK);
}

TEST(Statuses, ErrorsNameWhatIsWrong) {
    touch_camera camera = Hill::camera();
    touch_scene scene{};
    touch_error error = no_error();
    camera.metres_per_code = -1;
    EXPECT_EQ(touch_scene_from_camera(&camera, &scene, &error), TOUCH_USAGE);
    EXPECT_NE(std::string(error.line).find("metres_per_code"), std::string::npos) << error.line;
    camera = Hill::camera();
    camera.fx_px = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(touch_scene_from_camera(&camera, &scene, &error), TOUCH_USAGE);
    const std::string text = R"({"touchable_scene": 1, "nonsense": 3})";
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &error), TOUCH_INPUT);
    EXPECT_GT(std::string(error.line).size(), 10U);
    touch_error small{offsetof(touch_error, line) + 8, 0, {}};
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &small), TOUCH_INPUT);
    EXPECT_EQ(std::string(small.line).size(), 7U) << "cut where there is no room";
}

/// A scene that ends at 1 m (Hill), and floats of which some are beyond.
class FarDepth : public testing::Test {
protected:
    FarDepth() : touched_(), metres_(static_cast<std::size_t>(pixels), 0.5F) {}

    touch_status push(std::int64_t number = 1) {
        touch_frame frame = hill_.frame(number);
        frame.depth = {metres_.data(), 4 * Hill::width, Hill::width, Hill::height, TOUCH_F32, 1};
        frame.lost_pixels = &lost_;
        error_ = no_error();
        return touch_surface_push(touched_.surface, &frame, &error_);
    }
    void fill(std::int64_t count, float metres) { std::fill_n(metres_.begin(), count, metres); }

    static constexpr std::int64_t pixels = std::int64_t{Hill::width} * Hill::height;
    TouchedHill touched_;
    const Hill hill_;
    std::vector<float> metres_;
    std::int64_t lost_ = -1;
    touch_error error_{};
};

TEST_F(FarDepth, IsCounted) {
    fill(pixels / 2, 3);
    metres_[0] = std::numeric_limits<float>::quiet_NaN();
    metres_[1] = std::numeric_limits<float>::infinity();
    metres_[2] = -3;
    metres_[3] = 0;
    EXPECT_EQ(push(), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, pixels / 2 - 4);
    fill(pixels, 0.5F);
    EXPECT_EQ(push(2), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, 0);
}

TEST_F(FarDepth, IsRefusedWhereItIsMost) {
    fill(pixels / 2 + 1, 3);
    metres_[0] = 80;
    EXPECT_EQ(push(), TOUCH_USAGE);
    EXPECT_EQ(lost_, pixels / 2 + 1);
    const std::string line = error_.line;
    for (const char* said : {"1537 of its 3072", "0 to 1 m", "3 to 80", "millimetres", "far_m"})
        EXPECT_NE(line.find(said), std::string::npos) << said << ": " << line;
    // A lens that is covered but for some noise tells nothing of units.
    fill(pixels, 0);
    fill(pixels / 100 - 1, 3);
    EXPECT_EQ(push(), TOUCH_OK) << error_.line;
}

TEST_F(FarDepth, IsNotARenderersBackground) {
    fill(pixels * 3 / 4, 1e10F);
    fill(pixels / 4, 65504);
    EXPECT_EQ(push(), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, 0);
    fill(1, 65505);  // so 65504 is a depth
    EXPECT_EQ(push(2), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, pixels / 4);
}

TEST(Statuses, FramesAreCheckedAndInOrder) {
    TouchedHill touched;
    const Hill hill;
    touch_error error = no_error();
    touch_frame frame = hill.frame(0);
    EXPECT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_USAGE) << "not later";
    frame = hill.frame(1);
    frame.depth.width = 63;
    EXPECT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_USAGE);
    EXPECT_NE(std::string(error.line).find("63x48"), std::string::npos) << error.line;
    frame = hill.frame(1);
    frame.depth.stride_bytes = 3;
    EXPECT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_USAGE);
    frame = hill.frame(1);
    frame.haptic = frame.depth;
    EXPECT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_USAGE);
    for (const std::int64_t far : {INT64_MIN, INT64_MAX}) {
        frame = hill.frame(1);
        frame.time_ns = far;
        EXPECT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_USAGE);
        EXPECT_NE(std::string(error.line).find("time_ns"), std::string::npos) << error.line;
    }
    int pushed = 0;
    touch_status status = TOUCH_OK;
    for (std::int64_t n = 1; n < 20 && status == TOUCH_OK; ++n) {
        frame = hill.frame(n);
        status = touch_surface_push(touched.surface, &frame, &error);
        pushed += status == TOUCH_OK;
    }
    EXPECT_EQ(status, TOUCH_FULL) << "nobody ticks";
    EXPECT_GE(pushed, 2);
    EXPECT_EQ(touch_surface_begin_epoch(touched.surface, 1, &error), TOUCH_OK);
    EXPECT_EQ(touch_surface_begin_epoch(touched.surface, 1, &error), TOUCH_USAGE);
    EXPECT_EQ(touch_surface_end_epoch(touched.surface), TOUCH_OK);
}

TEST(Statuses, TicksGoForwardAndGoalsThatAreNoNumbersRampAway) {
    TouchedHill touched;
    touch_contact contact;
    const touch_vec3 deep{0, 0, -0.44};
    for (std::int64_t tick = 0; tick < 200; ++tick) {
        const touch_tick at = tick_at(tick);
        ASSERT_EQ(touch_solver_tick(touched.solver, &at, &deep, &contact, sizeof contact), TOUCH_OK);
    }
    EXPECT_GT(contact.force_n.z, 0.5);
    EXPECT_EQ(contact.touching, 1);
    touch_tick at = tick_at(199);
    EXPECT_EQ(touch_solver_tick(touched.solver, &at, &deep, &contact, sizeof contact), TOUCH_USAGE)
        << "again";
    at = tick_at(200);
    EXPECT_EQ(touch_solver_tick(touched.solver, &at, &deep, &contact, 8), TOUCH_USAGE) << "no room";
    const touch_vec3 nowhere{NAN, 0, 0};
    double before = contact.force_n.z;
    for (std::int64_t tick = 200; tick < 320; ++tick) {
        at = tick_at(tick);
        ASSERT_EQ(touch_solver_tick(touched.solver, &at, &nowhere, &contact, sizeof contact), TOUCH_OK);
        EXPECT_LE(contact.force_n.z, before);
        EXPECT_TRUE(contact.guard & TOUCH_GUARD_FAULT);
        before = contact.force_n.z;
    }
    EXPECT_EQ(contact.force_n.z, 0);
}

TEST(Statuses, NoForceIsLongerThanTheCallerAllows) {
    touch_solver_settings settings;
    touch_solver_settings_defaults(&settings, sizeof settings);
    settings.max_force_n = 0.25;
    TouchedHill touched(&settings);
    touch_contact contact;
    for (std::int64_t tick = 0; tick < 300; ++tick) {
        const touch_tick at = tick_at(tick);
        const touch_vec3 goal = goal_at(tick);
        ASSERT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
        EXPECT_LE(std::hypot(contact.force_n.x, contact.force_n.y, contact.force_n.z), 0.25);
    }
}

TEST(Statuses, AScenesTextGivesTheSceneAgain) {
    touch_scene scene{}, again{};
    const touch_camera camera = Hill::camera();
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    std::size_t length = 0;
    ASSERT_EQ(touch_scene_text(scene, nullptr, 0, &length), TOUCH_OK);
    std::string text(length, ' ');
    ASSERT_EQ(touch_scene_text(scene, text.data(), text.size(), &length), TOUCH_OK);
    touch_error error = no_error();
    ASSERT_EQ(touch_scene_from_text(text.data(), text.size(), &again, &error), TOUCH_OK)
        << error.line << text;
    std::string same(length, ' ');
    ASSERT_EQ(touch_scene_text(again, same.data(), same.size(), &length), TOUCH_OK);
    EXPECT_EQ(text, same);
    touch_scene_facts facts{};
    facts.struct_size = sizeof facts;
    ASSERT_EQ(touch_scene_describe(again, &facts), TOUCH_OK);
    EXPECT_EQ(facts.width, Hill::width);
    EXPECT_EQ(facts.fx_px, 60);
    EXPECT_EQ(facts.metres_per_scene_unit, 1);
    EXPECT_EQ(facts.unstated_filters, 1) << "a camera states no filter";
    touch_scene filtered{};
    const Hill hill;
    std::vector<touch_frame> frames;
    for (int k = 0; k < 5; ++k) frames.push_back(hill.frame(k));
    ASSERT_EQ(
        touch_scene_with_filters(scene, frames.data(), sizeof frames[0], frames.size(), &filtered, &error),
        TOUCH_OK)
        << error.line;
    ASSERT_EQ(touch_scene_describe(filtered, &facts), TOUCH_OK);
    EXPECT_EQ(facts.unstated_filters, 0);
    for (const touch_scene each : {scene, again, filtered}) EXPECT_EQ(touch_scene_destroy(each), TOUCH_OK);
}

}  // namespace
}  // namespace touchable::test
