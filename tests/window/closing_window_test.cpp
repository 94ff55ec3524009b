// A window is closed while a disk hangs.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "engine/base/threads.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/window/fake_hand.hpp"
#include "tests/window/hung_disk.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/two_surfaces.hpp"

namespace touchable::test {
namespace {

using Clock = std::chrono::steady_clock;

class HungDiskWindow : public ::testing::Test {
protected:
    void SetUp() override {
        clip_ = folder_ / "clip.mkv";
        ASSERT_NO_FATAL_FAILURE(write_two_surfaces(clip_, 30));
        fake_->motion = [](std::int64_t tick) { return glm::dvec3(0, 0, tick % 200 < 100 ? 0.12 : -0.04); };
    }
    PlayOptions options(const std::string& script) {
        PlayOptions options = headless_by_cpu(clip_);
        options.seconds = 60;
        options.script = inputs_of("0 loop\n" + script);
        return options;
    }
    /// The disk hangs until the window is gone, or is not for so long that it never would be.
    Result<PlayFigures> play(const PlayOptions& options) {
        HungDisk disk(folder_.path());
        std::atomic<bool> is_gone{false}, answered_too_late{false};
        std::thread looks_on([&] {
            const auto begun = Clock::now();
            while (!is_gone && Clock::now() < begun + std::chrono::seconds(60)) {
                if (fake_->newtons > 0.1) felt_ = Clock::now();
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            answered_too_late = !is_gone;
            disk.answer();
        });
        testing::internal::CaptureStderr();
        auto played = play_in_window(options);
        told_ = testing::internal::GetCapturedStderr();
        gone_ = Clock::now();
        asked_ = disk.asked();
        abandoned_ = abandoned_threads;
        is_gone = true;
        looks_on.join();
        EXPECT_FALSE(answered_too_late) << "the window waited for the disk";
        return played;
    }
    /// How often it was told.
    int told(const std::string& words) const {
        int count = 0;
        for (std::size_t at = 0; (at = told_.find(words, at)) != std::string::npos; ++at) ++count;
        return count;
    }

    const TemporaryFolder folder_;
    std::filesystem::path clip_;
    const std::shared_ptr<FakeHand> fake_ = std::make_shared<FakeHand>();
    Clock::time_point felt_, gone_;  // written by the thread that looks on, until it is joined
    std::string told_;
    int asked_ = 0, abandoned_ = 0;
};

TEST_F(HungDiskWindow, ClosesAndNamesUnfinishedPictures) {
    const std::string a = (folder_ / "a.png").string(), b = (folder_ / "b.png").string();
    PlayOptions asked = options("0.1 key f\n1.4 screenshot " + a + "\n1.5 screenshot " + b + "\n1.6 quit\n");
    asked.hand = std::make_shared<PersistentDevice>(fake_);
    const auto played = play(asked);
    EXPECT_TRUE(played) << played.error().message;
    EXPECT_EQ(told_, "touchable: warning: " + a + ": not finished: its disk does not answer\n" +
                         "touchable: warning: " + b + ": not finished: its disk does not answer\n");
    EXPECT_GT(fake_->most_newtons, 0.1);
    EXPECT_GT(gone_ - felt_, std::chrono::milliseconds(1500)) << "there was force while the window waited";
    EXPECT_EQ(asked_, 1) << "one picture after the other";
    EXPECT_EQ(abandoned_, 1) << "the program would take apart what the thread uses";
}

TEST_F(HungDiskWindow, ClosesWithUnfinishedScreenshot) {
    PlayOptions asked = options("");
    asked.screenshot = folder_ / "a.png";
    asked.seconds = 0.5;
    const auto played = play(asked);
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().message,
              (folder_ / "a.png").string() + ": not finished: its disk does not answer");
    EXPECT_EQ(told_, "");
}

TEST_F(HungDiskWindow, ClosesAndNamesBrushFiles) {
    const std::string saved = (folder_ / "saved.json").string();
    PlayOptions asked =
        options("0.2 material foam\n0.3 paint 20,32\n0.4 save-materials " + saved + "\n0.5 mute\n1.5 quit\n");
    asked.brush_history = folder_ / "state";
    asked.settings_file = folder_ / "play.json";
    const auto played = play(asked);
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().message, saved + ": not finished: its disk does not answer");
    EXPECT_EQ(told((folder_ / "state").string()), 1) << told_;
    EXPECT_EQ(told("settings are not kept: " + (folder_ / "play.json").string()), 1) << told_;
    EXPECT_EQ(told("not finished"), 2) << told_;
    EXPECT_EQ(asked_, 2) << "the history's disk, and that of settings";
}

TEST_F(HungDiskWindow, ClosesAndReportsLostPaint) {
    PlayOptions asked = options("0.2 material foam\n0.3 paint 20,32\n1.5 quit\n");
    asked.brush_history = folder_ / "state";
    asked.settings_file = folder_ / "play.json";
    const auto played = play(asked);
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_EQ(told("not finished"), 2) << told_;
    EXPECT_EQ(played->materials.rfind("what was painted is not saved; not all of it is in ", 0), 0U)
        << played->materials;
    EXPECT_EQ(told("touchable: warning: settings are not kept: " + (folder_ / "play.json").string() +
                   ": not finished: its disk does not answer\n"),
              1)
        << told_;
}

}  // namespace
}  // namespace touchable::test
