#include <gtest/gtest.h>

#include <chrono>
#include <glm/geometric.hpp>
#include <memory>
#include <thread>

#include "player/window/opened_clip.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

class ChangedClip : public ::testing::Test {
protected:
    void SetUp() override {
        const std::string file = (folder_ / "globe.mkv").string();
        ASSERT_EQ(run_touchable({"make", "globe", file, "--size", "64x48", "--frames", "60"}).code, 0);
        choice_.file = file;
        options_.session.builder.name = "cpu";
        auto opened = OpenedClip::open(options_, choice_, {}, *sound_);
        ASSERT_TRUE(opened.ok()) << opened.error().message;
        clip_ = std::move(*opened);
    }
    PlaybackState now() const { return clip_->session().playback(); }
    /// Commands take effect with a tick.
    template <class Condition>
    bool comes_true(const Condition& condition) {
        for (int k = 0; k < 5000; ++k) {
            if (condition()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return false;
    }
    Result<void> change(const char* name, const char* value) {
        FeltSettings felt = clip_->felt();
        if (auto set = felt.set(name, value); !set.ok()) return set;
        return clip_->change(felt);
    }

    const TemporaryFolder folder_;
    ClipChoice choice_;
    PlayOptions options_;
    std::unique_ptr<WindowSound> sound_ = std::move(*WindowSound::create(false, {}, Existing::keep));
    std::unique_ptr<OpenedClip> clip_;
};

TEST_F(ChangedClip, GoesOnWhereItWasAsItWas) {
    WatchedSession& before = clip_->session();
    ASSERT_TRUE(before.ask(PlaybackVerb::rate, 500).ok());
    ASSERT_TRUE(before.ask(PlaybackVerb::loop, 100'000'000, 1'500'000'000).ok());
    ASSERT_TRUE(before.ask(PlaybackVerb::seek, 700'000'000).ok());
    ASSERT_TRUE(before.ask(PlaybackVerb::pause).ok());
    ASSERT_TRUE(comes_true([this] { return !now().playing; }));
    const std::int64_t moment = now().moment.time_ns;
    ASSERT_TRUE(change("median", "5").ok());
    ASSERT_TRUE(comes_true([this] { return now().moment.epoch > 0 && !now().playing; }));
    EXPECT_EQ(now().moment.time_ns, moment);
    EXPECT_EQ(now().rate, 500);
    EXPECT_TRUE(now().loops);
    EXPECT_EQ(now().loop_end_ns, 1'500'000'000);
    EXPECT_EQ(clip_->in_effect().at("median"), "5");
    EXPECT_EQ(clip_->scene().filter.median, 5);
    // While it plays it plays on from there.
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::play).ok());
    ASSERT_TRUE(comes_true([&] { return now().moment.time_ns > moment + 20'000'000; }));
    ASSERT_TRUE(change("metric", "pixel").ok());
    EXPECT_TRUE(comes_true([&] { return now().playing && now().moment.time_ns > moment + 20'000'000; }));
    EXPECT_LT(now().moment.time_ns, moment + 400'000'000);
    EXPECT_EQ(clip_->in_effect().at("metric"), "pixel");
    EXPECT_EQ(clip_->in_effect().at("median"), "5");
}

TEST_F(ChangedClip, KeepsItsSessionWhereItDoesNotGoWithTheSettings) {
    const WatchedSession* const before = &clip_->session();
    ASSERT_TRUE(comes_true([this] { return now().moment.time_ns > 0; }));
    const auto refused = change("temporal", "on");
    ASSERT_FALSE(refused.ok()) << "a made clip has no noise";
    EXPECT_NE(refused.error().message.find("temporal"), std::string::npos);
    EXPECT_EQ(&clip_->session(), before);
    EXPECT_TRUE(clip_->session().running());
    EXPECT_TRUE(comes_true([this] { return now().playing; }));
    EXPECT_EQ(clip_->felt(), FeltSettings());
}

TEST_F(ChangedClip, FingerStaysPressedInAndIsFeltAgain) {
    const auto felt = [this] {
        const WatchedMoment* const moment = clip_->session().look();
        return moment && !moment->felt.fingers.empty() ? moment->felt.fingers[0] : WatchedFinger();
    };
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::pause).ok());
    ASSERT_TRUE(comes_true([this] { return clip_->session().look() != nullptr; }));
    const HeightField field(clip_->scene(), clip_->session().look()->held.pair);
    clip_->fingers().set_pointer(glm::dvec2(32, 24));
    clip_->fingers().press(true);
    clip_->fingers().intend(field, clip_->view().camera(64, 48));
    const auto presses = [&] { return glm::length(felt().force.force) > 0.1; };
    ASSERT_TRUE(comes_true(presses));
    const glm::dvec3 before = felt().goal;
    ASSERT_TRUE(change("metric", "pixel").ok());
    ASSERT_TRUE(comes_true([&] { return glm::length(felt().goal) > 0; }));
    // It is on its way in still; had it gone away, it would come from the camera.
    EXPECT_LT(glm::length(felt().goal - before), 0.2 * glm::length(before));
    EXPECT_TRUE(comes_true(presses));
}

}  // namespace
}  // namespace touchable::test
