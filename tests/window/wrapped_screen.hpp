#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "player/window/screen.hpp"

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

}  // namespace touchable::test
