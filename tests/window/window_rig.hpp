// SPDX-License-Identifier: Apache-2.0
#pragma once

// What windows' tests have: fingers and clips, screens and a hand that a test holds.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "device/haptic_device.hpp"
#include "engine/picture/image.hpp"
#include "player/run/touch_session.hpp"
#include "player/view/pointer.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/screen.hpp"
#include "player/window/window_clock.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/player/in_process.hpp"
#include "tests/view/shown.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {

/// A globe in a window, and the fingers of a pointer over it.
class FingersOverGlobe : public ::testing::Test {
protected:
    using Places = std::array<glm::dvec3, PointerFingers::most>;

    FingersOverGlobe(const glm::ivec2& clip, const glm::ivec2& window)
        : width_(window.x), height_(window.y), shown_(shown_scene("globe", clip.x, clip.y)) {
        EXPECT_TRUE(device_.open());
    }
    HeightField field() const { return shown_->field(); }
    ViewCamera camera() const { return view_.camera(width_, height_); }
    /// Where the fingers are after so many ticks on their way to the goals that they have, device metres.
    Places after(int ticks) {
        Places places{};
        for (int tick = 0; tick < ticks; ++tick) EXPECT_TRUE(device_.read_positions(places));
        return places;
    }
    /// So deep, device metres, in the surface that was met.
    glm::dvec3 place_in(const ViewCamera::Pick& met, double deep_m) const {
        return met.point + met.direction * (deep_m / workspace_.metres_per_scene_unit);
    }
    /// How deep a world place is in the surface that was met on its line of sight, device metres.
    double depth_in(const ViewCamera::Pick& met, const glm::dvec3& place) const {
        return glm::dot(place - met.point, met.direction) * workspace_.metres_per_scene_unit;
    }

    int width_, height_;
    std::unique_ptr<Shown> shown_;
    Workspace workspace_ = clip_workspace(shown_->scene, shown_->prev);
    PointerDevice device_{PointerFingers::most, workspace_.to_device({0, 0, 0})};
    std::optional<PointerFingers> fingers_{std::in_place, device_, workspace_};
    WindowView view_{shown_->scene, glm::dvec3(0, 0, -80)};
};

/// A clip of a wall, brown on its left half and blue on its right one: a segment each. 96x64 pixels, 0.16 m
/// of the hand wide; pixels (20, 32) and (70, 32) are of either.
inline void write_two_surfaces(const std::filesystem::path& file, int frames) {
    constexpr int width = 96, height = 64;
    Scene scene = small_scene(width, height, 8);
    scene.camera = {400, 400, 47.5, 31.5};
    scene.metres_per_unit = 0.001;
    auto writer = create_clip(file, scene, exact_clip);
    ASSERT_TRUE(writer) << writer.error().message;
    for (int n = 0; n < frames; ++n) {
        auto memory = std::make_shared<std::array<Image, 2>>();
        auto& [depth, colour] = *memory;
        depth = {width, height, 1, 1, std::vector<std::uint8_t>(std::size_t{width} * height, 120)};
        colour = {width, height, 1, 3, {}};
        for (int k = 0; k < width * height; ++k)
            for (const int value : k % width < width / 2 ? std::array{150, 100, 60} : std::array{60, 70, 150})
                colour.samples.push_back(static_cast<std::uint8_t>(value));
        RawFrame frame;
        frame.number = n;
        frame.time_ns = scene.rate.time_ns(n);
        frame.depth = depth.view();
        frame.colour = colour.view();
        frame.storage = std::move(memory);
        const auto written = (*writer)->write(frame);
        ASSERT_TRUE(written) << written.error().message;
    }
    ASSERT_TRUE((*writer)->finish());
}

/// A screen without a display, of which a test replaces some functions.
class WrappedScreen : public Screen {
public:
    explicit WrappedScreen(const ScreenOptions& options) : screen_(make_headless_screen(options)) {}
    std::vector<std::string> extensions() const override { return screen_->extensions(); }
    Result<void> attach(std::shared_ptr<GpuDevice> device) override {
        return screen_->attach(std::move(device));
    }
    Result<void> health() const override { return screen_->health(); }
    ScreenSize size() const override { return screen_->size(); }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        return screen_->poll(longest);
    }
    std::string touch_state() const override { return screen_->touch_state(); }
    Result<void> present(GpuCommands commands, const GpuImage& canvas) override {
        return screen_->present(std::move(commands), canvas);
    }
    void set_title(const std::string& title) override { screen_->set_title(title); }
    void set_fullscreen(bool on) override { screen_->set_fullscreen(on); }
    void set_size(int width, int height) override { screen_->set_size(width, height); }
    void hide_pointer(bool hidden) override { screen_->hide_pointer(hidden); }

private:
    const std::unique_ptr<Screen> screen_;
};

/// A screen whose time is its visitors', on a clock that it puts forward once the window shows pictures.
class PublicScreen : public Screen {
public:
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        if (is_open_) return next_events();
        std::this_thread::sleep_for(longest);
        return {};
    }
    Result<void> present(GpuCommands commands, const GpuImage&) override { return std::move(commands).run(); }
    void set_fullscreen(bool) override { ADD_FAILURE() << "a visitor has left full screen"; }

protected:
    virtual std::vector<InputEvent> next_events() = 0;
    static void put_forward(double seconds) {
        WindowClock::put_forward(
            std::chrono::duration_cast<WindowClock::duration>(std::chrono::duration<double>(seconds)));
    }

    bool is_open_ = false;  // set by set_size, which the script calls
};

/// A device of one finger that a test holds: from its own thread, or by a motion over the ticks.
class FakeHand final : public HapticDevice {
public:
    std::string name() const override { return "fake"; }
    DeviceLimits limits() const override { return {5, 1000}; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return {.axes_driven = axes, .buttons = 1}; }
    Result<void> open() override {
        ++openings;
        if (is_slow && !wait_unless_stopped([this] { return !is_slow; }, std::chrono::milliseconds(1)))
            return interrupted_error();
        if (is_unplugged) return *health_of_unplugged();
        has_failed = false;
        return {};
    }
    void close() override { newtons = 0; }
    bool read_positions(std::span<glm::dvec3> places) override {
        if (has_failed) return false;
        const std::lock_guard lock(mutex_);
        if (motion) place_ = motion(reads);
        ++reads;
        places[0] = place_;
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> forces) override {
        if (has_failed) return false;
        newtons = glm::length(forces[0]);
        most_newtons = std::max(most_newtons.load(), newtons.load());
        return true;
    }
    std::uint32_t buttons() override { return pressed; }
    double age_s() const override {
        const std::lock_guard lock(mutex_);
        return std::isnan(place_.x) ? std::numeric_limits<double>::infinity() : 0.001;
    }
    std::string prompt() const override { return is_away ? "looking for the fake again" : ""; }
    Result<void> health() const override {
        if (is_away || has_failed) return *health_of_unplugged();
        return {};
    }

    void put(const glm::dvec3& place) {
        const std::lock_guard lock(mutex_);
        place_ = place;
    }
    void take_away() { put(glm::dvec3(std::numeric_limits<double>::quiet_NaN())); }

    int axes = 3;
    std::function<glm::dvec3(std::int64_t)> motion;  ///< before it is used: where it is at each reading
    std::atomic<std::int64_t> reads{0};
    std::atomic<std::uint32_t> pressed{0};
    std::atomic<double> newtons{0}, most_newtons{0};
    std::atomic<int> openings{0};
    std::atomic<bool> has_failed{false}, is_unplugged{false}, is_slow{false}, is_away{false};

private:
    static std::optional<Error> health_of_unplugged() {
        return Error{ErrorKind::device, "fake: nothing is plugged in"};
    }
    mutable std::mutex mutex_;
    glm::dvec3 place_{0, 0, 0.2};
};

/// A clip as a window has it, in sessions that come and go.
class OpenedClipTest : public ::testing::Test {
protected:
    /// Chooses a globe of 64x48 that is made for this.
    void make_globe(int frames) {
        choice_.file = folder_ / "globe.mkv";
        const SceneOptions globe{.width = 64, .height = 48, .properties = true};
        ASSERT_TRUE(write_generated_clip("globe", choice_.file, globe, frames));
    }
    /// Opens the chosen clip; nothing where that fails.
    std::unique_ptr<OpenedClip> opened(const ClipChoice& choice, const SessionSettings& settings = {}) {
        options_.session.builder.name = "cpu";
        auto made = OpenedClip::open(options_, choice, settings, *sound_);
        EXPECT_TRUE(made) << made.error().message;
        return made ? std::move(*made) : nullptr;
    }
    void begin() {
        clip_ = opened(choice_);
        ASSERT_TRUE(clip_ && clip_->begin());
    }
    Result<void> change_to(const SessionSettings& settings,
                           const std::shared_ptr<const PaintedSegments>& painted = nullptr) {
        auto change = clip_->prepare(settings, painted);
        if (!change) return change.error();
        EXPECT_TRUE(comes_true([&] { return clip_->has_come_to(*change); }));
        return clip_->take(std::move(*change));
    }
    Result<void> change(const char* name, const char* value) {
        SessionSettings settings = clip_->settings();
        if (auto set = settings.set(name, value); !set) return set;
        return change_to(settings);
    }
    /// Presses the pointer's finger at a pixel of the clip.
    void press(int x, int y) {
        ASSERT_TRUE(comes_true([this] { return clip_->session().look() != nullptr; }));
        const HeightField field(clip_->scene(), clip_->session().look()->held.pair);
        clip_->fingers().set_pointer(glm::dvec2(x, y));
        clip_->fingers().press(true);
        clip_->fingers().intend(field, clip_->view().camera(field.width(), field.height()));
    }
    /// The first finger as it was watched last.
    WatchedTick::Finger felt() {
        const WatchedMoment* const moment = clip_->session().look();
        return moment && !moment->felt.fingers.empty() ? moment->felt.fingers[0] : WatchedTick::Finger();
    }

    const TemporaryFolder folder_;
    ClipChoice choice_;
    PlayOptions options_;
    std::unique_ptr<WindowSound> sound_ = std::move(*WindowSound::create(false, {}, Existing::keep));
    std::unique_ptr<OpenedClip> clip_;
};

}  // namespace touchable::test
