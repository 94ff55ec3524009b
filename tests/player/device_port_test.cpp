// A hand that holds a device: where its goals are once forces push back. No clock takes part.
#include "player/run/touch_session.hpp"

#include <gtest/gtest.h>

#include <array>

#include "device/point_motion.hpp"
#include "engine/content/scenes.hpp"

namespace touchable::test {
namespace {

/// Means its fingers to be 10 units apart, moved along by one unit at tick 100.
class StillHand final : public Hand {
public:
    int fingers() const override { return 2; }
    void goals_at(std::int64_t tick, const SurfaceProbe&, std::span<glm::dvec3> goals) override {
        const double along = tick < 100 ? 0 : 1;
        goals[0] = {along, 0, -1000};
        goals[1] = {along + 10, 0, -1000};
    }
};

class HeldDevice : public ::testing::Test {
protected:
    HeldDevice() : content_(std::move(make_scene("plane", {.width = 16, .height = 12})).value()) {
        content_->exact_frame(0, frame_);
        pair_.prev = pair_.next = {0, 0, &frame_};
        EXPECT_TRUE(device_.open());
    }
    bool read(std::int64_t tick) { return port_->read_goals(tick, {content_->scene(), pair_}, goals_); }

    std::unique_ptr<AnalyticScene> content_;
    SurfaceFrame frame_;
    FramePair pair_;
    StillHand hand_;
    SimulatedDevice device_{
        2, {.max_force = 8, .max_stiffness = 2000}, {.damping = 20, .hand_stiffness = 250}};
    std::unique_ptr<HapticPort> port_ = make_port(hand_, device_, {0.001, {0, 0, -1000}});
    std::array<glm::dvec3, 2> goals_{};
};

TEST_F(HeldDevice, BeginsWhereTheHandMeansItToBeAndFollowsIt) {
    ASSERT_TRUE(read(0));
    EXPECT_EQ(goals_[0], glm::dvec3(0, 0, -1000));
    EXPECT_EQ(goals_[1], glm::dvec3(10, 0, -1000));
    for (int tick = 1; tick <= 101; ++tick) ASSERT_TRUE(read(tick));
    EXPECT_GT(goals_[0].x, 0) << "on its way";
    EXPECT_LT(goals_[0].x, 0.1) << "but not there at once";
    for (int tick = 102; tick <= 1500; ++tick) ASSERT_TRUE(read(tick));
    EXPECT_NEAR(goals_[0].x, 1, 1e-6);
    EXPECT_NEAR(goals_[1].x, 11, 1e-6);
}

TEST_F(HeldDevice, YieldsToTheForceOfItsFingerAlone) {
    const std::array forces{glm::dvec3(0, 0, 0.5), glm::dvec3(0)};
    for (int tick = 0; tick < 90; ++tick) {
        ASSERT_TRUE(read(tick));
        ASSERT_TRUE(port_->write_forces(forces));
    }
    // 2 mm in the end, of a hand of 250 N/m; on the way there.
    EXPECT_GT(goals_[0].z, -999);
    EXPECT_LT(goals_[0].z, -998);
    EXPECT_EQ(goals_[1], glm::dvec3(10, 0, -1000));
}

TEST_F(HeldDevice, TicksThatWereSkippedPassForTheHandleToo) {
    const std::array forces{glm::dvec3(0, 0, 0.5), glm::dvec3(0)};
    ASSERT_TRUE(read(0));
    ASSERT_TRUE(port_->write_forces(forces));
    ASSERT_TRUE(read(30));
    const double once = goals_[0].z;
    SimulatedDevice other(2, device_.limits(), {.damping = 20, .hand_stiffness = 250});
    ASSERT_TRUE(other.open());
    const auto port = make_port(hand_, other, {0.001, {0, 0, -1000}});
    for (int tick = 0; tick <= 30; ++tick) {
        ASSERT_TRUE(port->read_goals(tick, {content_->scene(), pair_}, goals_));
        ASSERT_TRUE(port->write_forces(forces));
    }
    EXPECT_EQ(goals_[0].z, once);
}

TEST_F(HeldDevice, ThatFailsSaysSo) {
    ASSERT_TRUE(read(0));
    device_.fail("was unplugged");
    EXPECT_FALSE(read(1));
    EXPECT_FALSE(port_->write_forces(goals_));
}

}  // namespace
}  // namespace touchable::test
