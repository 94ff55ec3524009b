// What a hand is given when its program does what programs do: goals that go missing, frames that come
// meanwhile, settings at their ends.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "capi/touchable.hpp"
#include "tests/capi/hill.hpp"

namespace touchable::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr touch_vec3 missing{nan, nan, nan};

/// A wall that may come nearer, and a finger that presses on it.
class PressedWall {
public:
    explicit PressedWall(const touch_solver_settings& settings)
        : scene_(camera()), surface_(scene_), solver_((push(0.5), surface_), settings) {}

    static touch_solver_settings settings() {
        touch_solver_settings settings = touch::solver_settings();
        settings.metres_per_scene_unit = 1;
        return settings;
    }
    /// From the coming tick on.
    void push(double depth_m) {
        std::vector<float> metres(static_cast<std::size_t>(Hill::width) * Hill::height,
                                  static_cast<float>(depth_m));
        touch_frame frame = touch::frame();
        frame.number = frames_;
        frame.time_ns = frames_ == 0 ? 0 : (tick_ - 1) * 1'000'000;
        frame.depth = {metres.data(), 4 * Hill::width, Hill::width, Hill::height, TOUCH_F32, 1};
        ++frames_;
        EXPECT_TRUE(surface_.push(frame));
    }
    /// Newtons towards the eye.
    double tick(const touch_vec3& goal) {
        touch_contact contact;
        EXPECT_EQ(solver_.tick(touch::tick_at(tick_++), &goal, &contact), TOUCH_OK);
        return contact.force_n.z;
    }
    void come_back() { solver_.come_back(); }

private:
    static touch_camera camera() {
        touch_camera camera = Hill::camera();
        camera.metres_per_code = 0.0001;
        camera.far_m = 6;
        return camera;
    }

    std::int64_t tick_ = 1, frames_ = 0;
    touch::Scene scene_;
    touch::Surface surface_;
    touch::Solver solver_;
};

class Missing : public testing::TestWithParam<int> {};

/// A tracker loses the finger for some milliseconds, and a nearer surface comes meanwhile.
TEST_P(Missing, GoalsReturnWithoutAStepOfForce) {
    for (const bool has_frame : {false, true}) {
        PressedWall wall(PressedWall::settings());
        const touch_vec3 goal{0, 0, -0.503};
        for (int k = 0; k < 300; ++k) wall.tick(goal);
        double before = wall.tick(goal), most = 0;
        EXPECT_GT(before, 1.5) << "it presses";
        for (int k = 0; k < GetParam(); ++k) {
            if (has_frame && k == 0) wall.push(0.4865);
            before = wall.tick(missing);
        }
        for (int k = 0; k < 300; ++k) {
            const double now = wall.tick(goal);
            most = std::max(most, now - before);
            before = now;
        }
        // By a fade of what the device can give, over 100 ms (1.5 times its mean at its steepest), and the
        // ramp.
        EXPECT_LE(most, (1.5 + 1) * 10 / 100) << (has_frame ? "with a frame" : "without one");
        EXPECT_NEAR(before, 600 * (has_frame ? 0.0165 : 0.003), 0.2)
            << "in the end the surface is felt whole";
    }
}

INSTANTIATE_TEST_SUITE_P(ForceSafety, Missing, testing::Values(1, 5, 20, 40, 50, 60, 80, 99, 100, 120));

TEST(ForceSafety, RampsOfAnyLengthAreRamps) {
    touch_solver_settings settings = PressedWall::settings();
    settings.ramp_out_ticks = std::numeric_limits<std::int32_t>::max();
    PressedWall wall(settings);
    const touch_vec3 goal{0, 0, -0.51};
    for (int k = 0; k < 300; ++k) wall.tick(goal);
    wall.come_back();
    wall.tick(missing);
    double before = 0;
    for (int k = 0; k < 100; ++k) {
        const double now = wall.tick(goal);
        EXPECT_LE(now - before, 0.2);
        before = now;
    }
}

}  // namespace
}  // namespace touchable::test
