#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "player/window/screen.hpp"
#include "player/window/window_clock.hpp"

namespace touchable::test {

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
    std::vector<std::string> extensions() const override { return {}; }
    Result<void> attach(std::shared_ptr<GpuDevice>) override { return {}; }
    Result<void> health() const override { return {}; }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        if (is_open_) return next_events();
        std::this_thread::sleep_for(longest);
        return {};
    }
    Result<void> present(GpuCommands commands, const GpuImage&) override { return std::move(commands).run(); }
    std::string touch_state() const override { return ""; }
    void set_title(const std::string&) override {}
    void set_fullscreen(bool) override { ADD_FAILURE() << "a visitor has left full screen"; }
    void hide_pointer(bool) override {}

protected:
    virtual std::vector<InputEvent> next_events() = 0;
    static void put_forward(double seconds) {
        WindowClock::put_forward(
            std::chrono::duration_cast<WindowClock::duration>(std::chrono::duration<double>(seconds)));
    }

    bool is_open_ = false;  // set by set_size, which the script calls
};

}  // namespace touchable::test
