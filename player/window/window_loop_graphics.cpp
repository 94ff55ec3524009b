#include <chrono>
#include <utility>

#include "engine/base/try.hpp"

#include "player/window/window_loop.hpp"

// On what the window draws, and what it does where that is lost.

namespace touchable {
namespace {

// A GPU that is lost again so soon will be lost again.
constexpr std::chrono::seconds soon(10);

}  // namespace

/// What nobody sees needs no GPU, unless somebody asks for one.
Result<std::unique_ptr<WindowGraphics>> WindowLoop::make_graphics() {
    if (options_.headless && options_.painter == "cpu") return make_cpu_graphics();
    auto device = options_.gpu->open();
    const bool is_asked_for = options_.painter != "auto" || options_.session.builder.names_gpu();
    if (!device.ok() && options_.headless && (!is_asked_for || lost_at_)) return make_cpu_graphics();
    if (!device.ok()) return device.error();
    TRY(screen_->attach(*device));
    return make_gpu_graphics(std::move(*device), options_.painter, *screen_);
}

Result<void> WindowLoop::open_graphics() {
    TRY_ASSIGN(auto graphics, make_graphics());
    figures_.painter = graphics->painter();
    figures_.gpu = graphics->gpu();
    governor_ = PictureGovernor(graphics->thins_vertices() ? LessOf::vertices : LessOf::pixels);
    picture_.use(std::move(graphics));
    return {};
}

/// After an error of drawing: once, where the GPU was lost. The hand goes on meanwhile.
Result<void> WindowLoop::open_graphics_anew(const Error& error) {
    if (auto there = screen_->health(); !there.ok()) return there;
    const auto now = Clock::now();
    if (!picture_.graphics().is_lost() || (lost_at_ && now - *lost_at_ < soon)) return error;
    lost_at_ = now;
    picture_.use(nullptr);
    if (auto opened = open_graphics(); !opened.ok()) return opened;
    say(error.message + "; drawn by the " + figures_.painter + " painter on " +
            (figures_.gpu.empty() ? "the CPU" : figures_.gpu) + " from now on",
        Tone::fault);
    return {};
}

}  // namespace touchable
