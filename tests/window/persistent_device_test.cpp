// SPDX-License-Identifier: Apache-2.0
// A device that is held in place of the mouse: over sessions that come and go, and by the window.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <thread>

#include "haptics_cpu/force_guard.hpp"
#include "player/run/run_files.hpp"
#include "player/window/persistent_device.hpp"
#include "tests/limits.hpp"
#include "tests/player/touched.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

class DeviceClip : public OpenedClipTest {
protected:
    void SetUp() override {
        ASSERT_NO_FATAL_FAILURE(make_globe(2));
        options_.hand = std::make_shared<PersistentDevice>(fake_);
        ASSERT_NO_FATAL_FAILURE(begin());
        ASSERT_TRUE(comes_true([this] { return clip_->session().look() != nullptr; }));
        const FramePair pair = clip_->session().look()->held.pair;
        depth_ = pair.prev.frame->vertices->at(32, 24).depth;
    }
    /// Before the middle of the picture; below 0 behind its surface. By the mapping that it began with.
    void put_before(double metres) {
        fake_->put(clip_->session().setup().workspace.to_device({0, 0, -depth_}) + glm::dvec3(0, 0, metres));
    }
    bool comes_to(const glm::dvec3& scene) {
        return comes_true([&] { return glm::length(felt().goal - scene) < 1e-6; });
    }
    /// Presses, and feels it; it was free before. Where the machine stood still meanwhile it has to be free
    /// once more.
    void feel() {
        bool felt = false;
        for (int go = 0; go < 5 && !felt; ++go) {
            put_before(0.02);
            clip_->set_force(true);
            std::this_thread::yield();
            ASSERT_TRUE(pass(150));  // the guard's ramp, too
            put_before(-0.004);
            felt = comes_true([this] { return fake_->newtons > 0.1; }, 2000);
        }
        ASSERT_TRUE(felt);
    }
    /// Waits for so many more ticks.
    bool pass(int ticks) {
        return comes_true([this, since = fake_->reads + ticks] { return fake_->reads > since; });
    }
    HandState state() { return hand_state(*options_.hand, *clip_->control()); }

    const std::shared_ptr<FakeHand> fake_ = std::make_shared<FakeHand>();
    double depth_ = 0;
};

TEST_F(DeviceClip, ForcesReachDeviceOnRequest) {
    EXPECT_EQ(clip_->shown(), 1);
    EXPECT_EQ(state().words, "forces off - press F or the device's first button");
    put_before(-0.004);
    ASSERT_TRUE(comes_true([this] { return felt().contact.touching; }));
    EXPECT_EQ(glm::length(felt().force.force), 0) << "shown as it is in the hand";
    EXPECT_EQ(fake_->most_newtons, 0);
    feel();
    EXPECT_EQ(state().what, HandState::What::on);
    clip_->set_force(false);
    EXPECT_TRUE(comes_true([this] { return fake_->newtons == 0; }));
    EXPECT_EQ(state().what, HandState::What::off);
}

TEST_F(DeviceClip, CentreIsInTheAir) {
    const Workspace workspace = clip_->session().setup().workspace;
    EXPECT_EQ(workspace.to_scene({}).x, 0);
    EXPECT_NEAR(workspace.to_device({0, 0, -depth_}).z, -0.02, 0.01)
        << "the globe's middle is what is nearest";
}

TEST_F(DeviceClip, FirstButtonRequestsForces) {
    fake_->pressed = 0;
    ASSERT_TRUE(comes_true([this] { return fake_->reads > 20; }));
    fake_->pressed = 1;
    EXPECT_TRUE(comes_true([this] { return clip_->force_is_on(); }));
}

TEST_F(DeviceClip, ClutchHoldsFinger) {
    put_before(0.02);
    ASSERT_TRUE(comes_true([this] { return std::isfinite(felt().goal.z) && felt().goal.z < 0; }));
    const Workspace workspace = clip_->session().setup().workspace;
    const glm::dvec3 there =
        workspace.to_scene(workspace.to_device({0, 0, -depth_}) + glm::dvec3(0, 0, 0.02));
    ASSERT_TRUE(comes_to(there));
    clip_->control()->hold(true);
    ASSERT_TRUE(comes_true([this] { return state().words == "no force while the hand is repositioned"; }));
    put_before(0.05);
    ASSERT_TRUE(pass(20));
    EXPECT_TRUE(comes_to(there));
    clip_->control()->hold(false);
    ASSERT_TRUE(pass(20));
    EXPECT_TRUE(comes_to(there));
    put_before(0.06);
    EXPECT_TRUE(comes_to(there + glm::dvec3(0, 0, 0.01 / workspace.metres_per_scene_unit)));
}

TEST_F(DeviceClip, ClutchReleasedInsideFreesFinger) {
    feel();
    clip_->control()->hold(true);
    ASSERT_TRUE(comes_true([this] { return fake_->newtons == 0; }));
    put_before(0.03);
    ASSERT_TRUE(pass(20));
    ASSERT_TRUE(felt().contact.touching) << "it was held inside";
    clip_->control()->hold(false);
    ASSERT_TRUE(pass(20));
    EXPECT_TRUE(comes_true([this] { return !felt().contact.touching; }));
    EXPECT_EQ(fake_->newtons, 0);
    put_before(0.03 - 0.004);
    if (!comes_true([this] { return fake_->newtons > 0.1; }, 2000)) {  // the machine stood still
        put_before(0.03);
        ASSERT_TRUE(pass(20));
        put_before(0.03 - 0.004);
    }
    EXPECT_TRUE(comes_true([this] { return fake_->newtons > 0.1; }));
}

TEST_F(DeviceClip, ScaleChangeKeepsFinger) {
    const Workspace first = clip_->session().setup().workspace;
    fake_->put({0.01, 0.02, 0.05});
    ASSERT_TRUE(comes_to(first.to_scene({0.01, 0.02, 0.05})));
    ASSERT_TRUE(change("hand-scale", "0.5"));
    EXPECT_EQ(clip_->in_effect().at("hand-scale"), "0.5");
    EXPECT_TRUE(comes_to(first.to_scene({0.01, 0.02, 0.05})));
    fake_->put({0.01, 0.02, 0.07});
    EXPECT_TRUE(comes_to(first.to_scene({0.01, 0.02, 0.06}))) << "half as far";
    ASSERT_TRUE(change("hand-scale", "1"));
    EXPECT_EQ(clip_->session().setup().workspace.metres_per_scene_unit, first.metres_per_scene_unit);
    EXPECT_TRUE(comes_to(first.to_scene({0.01, 0.02, 0.06})));
    EXPECT_EQ(fake_->openings, 1) << "the hardware is held all the while";
}

TEST_F(DeviceClip, ChangeIsFeltAfterRelease) {
    feel();
    ASSERT_TRUE(change("median", "3"));
    EXPECT_TRUE(clip_->force_is_on());
    ASSERT_TRUE(comes_true([this] { return glm::length(felt().goal) > 0; }));
    fake_->most_newtons = 0;
    ASSERT_TRUE(pass(400));
    EXPECT_EQ(fake_->most_newtons, 0) << "it is pushed out of what it did not come into";
    const bool keeps_back = (felt().force.reasons & guard_waiting) != 0;
    EXPECT_EQ(hand_state(*options_.hand, *clip_->control(), keeps_back).remark,
              "lift the finger off the surface: then it is felt");
    feel();
}

TEST_F(DeviceClip, NextClipStartsWithoutForces) {
    feel();
    auto other = opened(choice_);
    ASSERT_TRUE(other && clip_->finish());
    EXPECT_EQ(fake_->newtons, 0);
    fake_->most_newtons = 0;
    clip_ = std::move(other);
    ASSERT_TRUE(clip_->begin());
    EXPECT_FALSE(clip_->force_is_on());
    ASSERT_TRUE(pass(100));
    EXPECT_EQ(fake_->most_newtons, 0);
}

TEST_F(DeviceClip, MotorlessDeviceShowsSceneForce) {
    ASSERT_TRUE(clip_->finish());
    fake_->axes = 0;
    ASSERT_NO_FATAL_FAILURE(begin());
    put_before(0.02);
    ASSERT_TRUE(pass(150));
    put_before(-0.004);
    EXPECT_TRUE(comes_true([this] { return glm::length(felt().force.force) > 0.1; }));
    EXPECT_FALSE(clip_->force_is_on());
}

TEST_F(DeviceClip, ReturnsAfterAbsence) {
    feel();
    fake_->is_away = true;
    fake_->take_away();
    EXPECT_EQ(state().words, "the device is away: fake: nothing is plugged in");
    ASSERT_TRUE(comes_true([this] { return fake_->newtons == 0; }));
    EXPECT_TRUE(clip_->session().running());
    fake_->is_away = false;
    feel();
}

TEST_F(DeviceClip, IsFoundAgainAfterLoss) {
    fake_->is_unplugged = fake_->has_failed = true;
    ASSERT_TRUE(comes_true([this] { return options_.hand->is_gone(); }));
    EXPECT_EQ(state().words, "no device: fake: nothing is plugged in - press F to look for it again");
    EXPECT_TRUE(clip_->session().running()) << "without a hand";
    ASSERT_TRUE(comes_true([this] { return std::isnan(felt().goal.x); }));
    options_.hand->look_again();
    ASSERT_TRUE(comes_true([this] { return options_.hand->is_gone(); })) << "it is not there";
    EXPECT_EQ(fake_->openings, 2);
    fake_->is_unplugged = false;
    options_.hand->look_again();
    ASSERT_TRUE(comes_true([this] { return state().what == HandState::What::off; }));
    clip_->set_force(false);
    feel();
}

/// A fake in the hand, which tests open.
class PersistentDeviceTest : public ::testing::Test {
protected:
    /// Reads where it is.
    bool read() { return hand.read_positions(std::span(&place, 1)); }
    bool push(double newtons) {
        const glm::dvec3 force(0, 0, newtons);
        return hand.write_forces(std::span(&force, 1));
    }

    const std::shared_ptr<FakeHand> fake = std::make_shared<FakeHand>();
    PersistentDevice hand{fake};
    glm::dvec3 place{};
};

TEST_F(PersistentDeviceTest, ReportsLackOfForce) {
    fake->axes = 0;
    ASSERT_TRUE(hand.open());
    const HandControl control(1, {});
    const HandState state = hand_state(hand, control);
    EXPECT_EQ(state.words, "the fake exerts no force: you see what you touch");
    EXPECT_EQ(state.remark, "fake: no position comes from it") << "none was read yet";
}

TEST_F(PersistentDeviceTest, FailedDeviceHasNoState) {
    fake->pressed = 1;
    ASSERT_TRUE(hand.open());
    ASSERT_TRUE(read());
    EXPECT_EQ(hand.age_s(), 0.001);
    EXPECT_EQ(hand.buttons(), 1U);
    fake->has_failed = true;
    for (const bool works_again : {false, true}) {
        if (works_again) fake->has_failed = false;
        EXPECT_TRUE(read()) << "the session goes on";
        EXPECT_TRUE(std::isnan(place.x) && std::isnan(place.y) && std::isnan(place.z)) << works_again;
        EXPECT_EQ(hand.age_s(), std::numeric_limits<double>::infinity());
        EXPECT_EQ(hand.buttons(), 0U);
        EXPECT_TRUE(hand.is_gone());
    }
}

TEST_F(PersistentDeviceTest, FailedDeviceGetsNoForce) {
    ASSERT_TRUE(hand.open());
    EXPECT_TRUE(push(3));
    EXPECT_EQ(fake->newtons, 3);
    fake->has_failed = true;
    EXPECT_TRUE(push(3)) << "the session goes on";
    EXPECT_TRUE(hand.is_gone());
    fake->has_failed = false;
    fake->newtons = 0;
    EXPECT_TRUE(push(3));
    EXPECT_EQ(fake->newtons, 0);
    hand.look_again();
    ASSERT_TRUE(comes_true([&] { return !hand.is_looked_for(); }));
    EXPECT_FALSE(hand.is_gone());
    EXPECT_TRUE(push(3));
    EXPECT_EQ(fake->newtons, 3);
}

TEST_F(PersistentDeviceTest, ClosingKeepsDeviceOpen) {
    ASSERT_TRUE(hand.open());
    ASSERT_TRUE(push(3));
    hand.close();
    EXPECT_EQ(fake->newtons, 0);
    ASSERT_TRUE(hand.open());
    EXPECT_EQ(fake->openings, 1);
}

TEST_F(PersistentDeviceTest, PowerOffBlocksForces) {
    ASSERT_TRUE(hand.open());
    EXPECT_TRUE(push(2));
    EXPECT_EQ(fake->newtons, 2);
    hand.power_off();
    EXPECT_TRUE(push(2));
    EXPECT_EQ(fake->newtons, 0);
}

TEST_F(PersistentDeviceTest, RejectsMissingDevice) {
    fake->is_unplugged = true;
    const auto opened = hand.open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, ErrorKind::device);
    EXPECT_FALSE(read());
}

TEST_F(PersistentDeviceTest, PowerOffCancelsSlowOpening) {
    fake->is_slow = true;
    std::jthread end([&] {
        EXPECT_TRUE(comes_true([&] { return fake->openings > 0; }));
        hand.power_off();
    });
    const auto opened = hand.open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, ErrorKind::interrupted);
}

TEST_F(PersistentDeviceTest, DestructorCancelsSearch) {
    ASSERT_TRUE(hand.open());
    fake->has_failed = fake->is_slow = true;
    EXPECT_TRUE(read());
    hand.look_again();
    EXPECT_TRUE(comes_true([&] { return fake->openings > 1; }));
    EXPECT_TRUE(hand.is_looked_for());
}  // whose destructor waits for the search

/// The window itself, without a display. The hand comes from before the globe, and presses into it after half
/// a second, and again.
class DeviceWindow : public ::testing::Test {
protected:
    void SetUp() override {
        const SceneOptions globe{.width = 64, .height = 48, .properties = true};
        ASSERT_TRUE(write_generated_clip("globe", clip_, globe, 60));
        motion_ = [](std::int64_t tick) {
            const double depth = std::clamp(static_cast<double>(tick % 700 - 400) / 200, 0.0, 1.0);
            return glm::dvec3(0, 0, 0.12 - 0.16 * depth);
        };
    }
    /// Until the motion had `ticks` of the seconds: where the machine stood still, ticks are skipped, and the
    /// story of the hand does not come to its end. Then it is played again.
    Result<PlayFigures> play(const std::string& script, std::int64_t ticks) {
        for (int go = 0;; ++go) {
            fake_ = std::make_shared<FakeHand>();
            fake_->motion = motion_;
            auto played = play_once(script);
            if (fake_->reads > ticks || go == most_standstills) return played;
        }
    }
    Result<PlayFigures> play_once(const std::string& script) {
        PlayOptions options = headless_by_cpu(clip_);
        options.hand = std::make_shared<PersistentDevice>(fake_);
        options.seconds = seconds_;
        options.record = record_;
        options.existing = Existing::replace;
        if (script.find("open ") != std::string::npos) options.record.reset();
        if (is_kiosk_) {
            options.kiosk = PlayOptions::Kiosk();
            options.kiosk->use_log = log_;
            options.record.reset();
        }
        options.script = inputs_of(script);
        return play_in_window(options);
    }

    const TemporaryFolder folder_;
    const std::filesystem::path clip_ = folder_ / "globe.mkv", record_ = folder_ / "hand.touch";
    const std::filesystem::path log_ = folder_ / "use.csv";
    bool is_kiosk_ = false;
    double seconds_ = 1.3;
    std::function<glm::dvec3(std::int64_t)> motion_;
    std::shared_ptr<FakeHand> fake_;  ///< of the last go
};

constexpr const char* clocks_drift =
    "the clocks of the script and of the hand drift apart when everything takes ten times as long";

TEST_F(DeviceWindow, ExertsNothingUntilRequested) {
    ASSERT_TRUE(play("0.1 move 100 100\n0.2 press left\n0.3 key 3\n", 900));
    EXPECT_GT(fake_->reads, 900);
    EXPECT_EQ(fake_->most_newtons, 0);
}

TEST_F(DeviceWindow, KeyEnablesForcesAndReplays) {
    seconds_ = 2.6;  // another scale is ready once it is prepared
    const auto played = play("0.1 key f\n0.7 key j\n0.9 key c\n1.0 key-up c\n1.1 key r\n", 1000);
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_GT(fake_->most_newtons, 0.1);
    EXPECT_EQ(fake_->newtons, 0) << "in the end";
    const auto recording = read_recording(record_);
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_EQ(recording->size(), 2U) << "another scale is another part";
    EXPECT_EQ(recording->front().fingers, 1);
    const double first = recording->front().facts.at("S"), second = recording->back().facts.at("S");
    EXPECT_NEAR(second / first, 1 / 0.8, 1e-12);
    const auto again = replay_in_process(record_);
    EXPECT_TRUE(again) << again.error().message;
}

TEST_F(DeviceWindow, NextClipStopsForces) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(clocks_drift);
    std::atomic<std::int64_t> last_felt{0};
    motion_ = [&](std::int64_t tick) {
        if (tick == 0 || fake_->newtons > 0) last_felt = tick;
        return glm::dvec3(0, 0, tick % 350 < 200 ? 0.12 : -0.04);
    };
    seconds_ = 4;
    ASSERT_TRUE(play("0.0 key f\n0.8 open " + clip_.string() + "\n", 3000));
    EXPECT_GT(fake_->most_newtons, 0.1);
    EXPECT_GT(fake_->reads - last_felt, 800) << "twice it was pressed in, after the other clip came";
}

/// A clip of another camera maps it to another place.
TEST_F(DeviceWindow, MovingHandIsKioskVisitor) {
    const auto other = folder_ / "other.mkv";
    ASSERT_TRUE(write_generated_clip("bumps", other, {.width = 128, .height = 96}, 60));
    is_kiosk_ = true;
    seconds_ = 2.6;
    for (const bool moves : {false, true}) {
        std::filesystem::remove(log_);
        motion_ = [&](std::int64_t tick) {
            const bool is_away = moves && tick % 100 < 50;
            return glm::dvec3(is_away ? 0.05 : 0.03, 0.02, 0.12);
        };
        ASSERT_TRUE(play("0.9 open " + other.string() + "\n", 2000));
        std::ifstream rows(log_);
        const std::string text((std::istreambuf_iterator<char>(rows)), {});
        EXPECT_TRUE(contains(text, ",start,"));
        EXPECT_EQ(text.find(",visit,") != std::string::npos, moves) << text;
    }
}

TEST_F(DeviceWindow, ContinuesWithoutLostDevice) {
    motion_ = [this](std::int64_t tick) {
        if (tick == 500) fake_->has_failed = fake_->is_unplugged = true;
        return glm::dvec3(0, 0, 0.12);
    };
    seconds_ = 2.6;
    const auto played = play("0.1 key f\n", 500);
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().kind, ErrorKind::device);
    EXPECT_EQ(played.error().message, "fake: nothing is plugged in");
    const auto again = replay_in_process(record_);
    EXPECT_TRUE(again) << again.error().message;
    const auto recording = read_recording(record_);
    ASSERT_TRUE(recording);
    EXPECT_GT(recording->front().ticks.size(), 520U) << "it ended with the device, after 501";
}

TEST_F(DeviceWindow, SilentDeviceNeedsNewRequest) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(clocks_drift);
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    std::atomic<std::int64_t> gone_from{0}, gone_to{0};  // once it was felt, and is out again
    motion_ = [&](std::int64_t tick) {
        if (tick == 0) gone_from = gone_to = std::numeric_limits<std::int64_t>::max() / 2;
        if (tick < gone_from && fake_->newtons > 0.1) {
            gone_from = (tick / 400 + 1) * 400;
            gone_to = gone_from + 1200;
        }
        if (tick == gone_to - 100) fake_->most_newtons = 0;
        if (tick > gone_from && tick < gone_to) return glm::dvec3(nowhere);
        return glm::dvec3(0, 0, tick % 400 < 250 ? 0.12 : -0.04);
    };
    seconds_ = 4;
    ASSERT_TRUE(play("0.0 key f\n", 3400));
    EXPECT_GT(fake_->reads, gone_to + 400) << "it was felt late, or never";
    EXPECT_EQ(fake_->most_newtons, 0) << "a surprise";
}

TEST_F(DeviceWindow, ForgetsRequestWhileAway) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(clocks_drift);
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    motion_ = [](std::int64_t tick) {
        if (tick < 2000) return glm::dvec3(nowhere);  // the key comes long before, on a slow machine too
        return glm::dvec3(0, 0, tick % 400 < 250 ? 0.12 : -0.04);
    };
    seconds_ = 3.4;
    ASSERT_TRUE(play("0.2 key f\n", 2900));
    EXPECT_GT(fake_->reads, 2900);
    EXPECT_EQ(fake_->most_newtons, 0) << "they were asked for long ago";
}

TEST_F(DeviceWindow, EndsDuringSearch) {
    motion_ = [this](std::int64_t tick) {
        if (tick == 300) fake_->has_failed = fake_->is_slow = true;
        return glm::dvec3(0, 0, 0.12);
    };
    const auto played = play("1.0 key f\n", 300);
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().kind, ErrorKind::device);
    EXPECT_EQ(fake_->openings, 2);
}

TEST_F(DeviceWindow, KeyFindsDeviceWithoutForces) {
    motion_ = [this](std::int64_t tick) {
        if (tick == 700) fake_->has_failed = true;
        return glm::dvec3(0, 0, tick < 700 || tick % 200 < 100 ? 0.12 : -0.04);
    };
    seconds_ = 2.2;
    ASSERT_TRUE(play("0.0 key f\n1.4 key f\n", 900));
    EXPECT_GT(fake_->reads, 900) << "it was not opened again";
    EXPECT_EQ(fake_->most_newtons, 0);
}

}  // namespace
}  // namespace touchable::test
