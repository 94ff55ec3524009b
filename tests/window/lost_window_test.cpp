// What a window does where the GPU it draws on, its display, or its clip is lost.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <thread>

#include "engine/picture/image.hpp"
#include "player/run/run_files.hpp"
#include "player/session/touch_setup.hpp"
#include "player/window/play_window.hpp"
#include "tests/gpu/blockade.hpp"
#include "tests/player/program.hpp"
#include "tests/window/wrapped_screen.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;

class LostWindow : public ::testing::Test {
protected:
    void SetUp() override {
        const std::string file = (folder_ / "globe.mkv").string();
        ASSERT_EQ(run_touchable({"make", "globe", file, "--size", "160x120", "--frames", "40"}).code, 0);
        options_.session.clip.file = file;
        options_.session.builder.name = "cpu";
        options_.gpu = gpu_;
        options_.headless = true;
        options_.screen = {320, 200, false};
        options_.record = folder_ / "hand.touch";
        options_.painter = "raster";
        options_.seconds = 1.2;
        options_.screenshot = folder_ / "shot.png";
        options_.script = {{0.1, WindowCommand{WindowVerb::screenshot, 0, first_picture().string()}}};
    }
    std::filesystem::path first_picture() const { return folder_ / "first.png"; }
    /// Loses something once the window shows pictures, and plays to the end.
    Result<PlayFigures> play(const std::function<void()>& lose) {
        auto loss = std::async(std::launch::async, [&] {
            while (!has_ended_ && !std::filesystem::exists(first_picture()))
                std::this_thread::sleep_for(10ms);
            lose();
        });
        auto played = play_in_window(options_);
        has_ended_ = true;
        loss.get();
        return played;
    }
    std::shared_ptr<GpuDevice> device() { return *gpu_->open(); }
    /// Of the hand, as its recording has it.
    double last_tick_s() const {
        const auto recording = read_recording(folder_ / "hand.touch");
        if (!recording || recording->empty() || recording->back().ticks.empty()) return 0;
        return 1e-9 * static_cast<double>(recording->back().ticks.back().time_ns);
    }

    const TemporaryFolder folder_;
    const std::shared_ptr<RunGpu> gpu_ = std::make_shared<RunGpu>("auto");
    PlayOptions options_;
    std::atomic<bool> has_ended_{false};
};

TEST_F(LostWindow, OpensAGpuThatIsLostAnew) {
    const auto first = device();
    const auto played = play([&] { first->lose(); });
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_EQ(played->painter, "raster");
    EXPECT_GT(last_tick_s(), 1.1);
    const auto shot = read_image(folder_ / "shot.png");
    ASSERT_TRUE(shot) << shot.error().message;
    EXPECT_EQ(shot->width, 320);
}

TEST_F(LostWindow, WaitsForNoGpuThatHangs) {
    std::optional<Blockade> blockade;
    const auto first = device();
    const auto played = play([&] {
        first->set_patience(50ms);
        blockade.emplace(*first);
    });
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_TRUE(first->lost());
    EXPECT_TRUE(read_image(folder_ / "shot.png"));
    EXPECT_GT(last_tick_s(), 1.1);
}

TEST_F(LostWindow, EndsWhereItsGpuIsLostAgainSoon) {
    options_.seconds = 9;
    const auto played = play([&] {
        // It is opened anew by whoever comes first, and lost before or after the window has drawn on it.
        for (; !has_ended_; std::this_thread::sleep_for(100ms)) device()->lose();
    });
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().kind, ErrorKind::gpu);
    EXPECT_GT(last_tick_s(), 0);
}

TEST_F(LostWindow, LeavesTheLastSurfaceOfAClipThatBreaks) {
    options_.session.playback = {{0, PlaybackVerb::loop, 0, 1'300'000'000}};
    options_.painter = "cpu";
    const auto played = play([&] { std::filesystem::resize_file(options_.session.clip.file, 20'000); });
    // It ran to its end, with the hand, and then says what was wrong.
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().kind, ErrorKind::input) << played.error().message;
    EXPECT_NE(played.error().message.find("globe.mkv"), std::string::npos) << played.error().message;
    EXPECT_GT(last_tick_s(), 1.1);
    EXPECT_TRUE(read_image(folder_ / "shot.png"));
}

TEST_F(LostWindow, OfAKioskOpensAClipThatComesBack) {
    const auto file = options_.session.clip.file, aside = folder_ / "aside.mkv";
    std::filesystem::copy(file, aside);
    options_.record.reset();
    options_.painter = "cpu";
    options_.kiosk = KioskOptions{.times = {60, 0.3}};
    options_.seconds = 2.6;
    for (const double seconds : {2.3, 2.45})
        options_.script.push_back(
            {seconds, WindowCommand{WindowVerb::screenshot, 0,
                                    (folder_ / (std::to_string(seconds) + ".png")).string()}});
    const auto played = play([&] {
        std::filesystem::resize_file(file, 20'000);
        std::this_thread::sleep_for(800ms);
        std::filesystem::copy(aside, file, std::filesystem::copy_options::overwrite_existing);
    });
    EXPECT_TRUE(played) << "a fault that is over: " << played.error().message;
    const auto picture = [&](double seconds) {
        return read_image(folder_ / (std::to_string(seconds) + ".png"));
    };
    const auto first = picture(2.3), second = picture(2.45);
    ASSERT_TRUE(first && second);
    EXPECT_TRUE(first->samples != second->samples) << "it stands still";
}

/// A display that is gone once `is_gone` is set.
class VanishingScreen final : public WrappedScreen {
public:
    VanishingScreen(const ScreenOptions& options, const std::atomic<bool>& is_gone)
        : WrappedScreen(options), is_gone_(is_gone) {}
    Result<void> health() const override {
        if (!is_gone_) return {};
        return Error{ErrorKind::gpu, "the display that the window was on has gone away"};
    }

private:
    const std::atomic<bool>& is_gone_;
};

TEST_F(LostWindow, LostDisplayDecidesExitCode) {
    for (const bool is_kiosk : {true, false}) {
        const auto file = options_.session.clip.file, aside = folder_ / "aside.mkv";
        std::filesystem::copy(file, aside, std::filesystem::copy_options::overwrite_existing);
        options_.record.reset();
        options_.screenshot.reset();
        options_.existing = Existing::replace;
        std::filesystem::remove(first_picture());
        has_ended_ = false;
        options_.session.playback = {{0, PlaybackVerb::loop, 0, 1'300'000'000}};
        options_.painter = "cpu";
        if (is_kiosk) options_.kiosk = KioskOptions{.times = {60, 0.3}};
        if (!is_kiosk) options_.kiosk.reset();
        options_.seconds = 60;
        std::atomic<bool> is_gone{false};
        options_.make_screen = [&is_gone](const ScreenOptions& size) {
            return std::make_unique<VanishingScreen>(size, is_gone);
        };
        const auto played = play([&] {
            std::filesystem::resize_file(file, 20'000);
            std::this_thread::sleep_for(3s);  // the clip is read to there at once
            is_gone = true;
        });
        std::filesystem::copy(aside, file, std::filesystem::copy_options::overwrite_existing);
        ASSERT_FALSE(played);
        EXPECT_EQ(played.error().kind, ErrorKind::gpu) << is_kiosk << ": " << played.error().message;
    }
}

TEST_F(LostWindow, SaysInTheEndThatAClipBeforeTheLastBroke) {
    const std::string other = (folder_ / "other.mkv").string();
    ASSERT_EQ(run_touchable({"make", "globe", other, "--size", "64x48", "--frames", "3"}).code, 0);
    options_.record.reset();
    options_.painter = "cpu";
    options_.script.push_back({0.9, WindowCommand{WindowVerb::open, 0, other}});
    const auto played = play([&] { std::filesystem::resize_file(options_.session.clip.file, 20'000); });
    ASSERT_FALSE(played);
    EXPECT_NE(played.error().message.find("globe.mkv"), std::string::npos) << played.error().message;
}

}  // namespace
}  // namespace touchable::test
