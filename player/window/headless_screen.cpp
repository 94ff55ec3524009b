#include <thread>
#include <utility>

#include "player/window/screen.hpp"

namespace touchable {
namespace {

class HeadlessScreen final : public Screen {
public:
    explicit HeadlessScreen(const ScreenOptions& options) : size_{options.width, options.height, 1} {}

    std::vector<std::string> extensions() const override { return {}; }
    Result<void> attach(std::shared_ptr<GpuDevice>) override { return {}; }
    Result<void> health() const override { return {}; }
    ScreenSize size() const override { return size_; }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        std::this_thread::sleep_for(longest);
        return {};
    }
    std::string touch_state() const override { return {}; }
    Result<void> present(GpuCommands commands, const GpuImage&) override { return std::move(commands).run(); }
    void set_title(const std::string&) override {}
    void set_fullscreen(bool) override {}
    void set_size(int width, int height) override { size_ = {width, height, 1}; }
    void hide_pointer(bool) override {}

private:
    ScreenSize size_;
};

}  // namespace

std::unique_ptr<Screen> make_headless_screen(const ScreenOptions& options) {
    return std::make_unique<HeadlessScreen>(options);
}

}  // namespace touchable
