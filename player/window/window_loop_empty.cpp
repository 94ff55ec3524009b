#include <chrono>
#include <utility>
#include <variant>

#include "player/terminal/interrupt.hpp"
#include "player/window/window_loop.hpp"

// A window for which nobody has named a clip yet.

namespace touchable {

/// What is dropped is opened. What cannot be is told, and something else is waited for.
Result<void> WindowLoop::wait_for_wish() {
    screen_->set_title("touchable");
    while (!clip_ && !quit_ && !interrupted()) {
        if (auto drawn = draw_opening(); !drawn.ok()) return drawn;
        if (!begun_) {
            begun_ = Clock::now();
            begun_cpu_ms_ = thread_cpu_ms();
            figures_.first_picture_ms = 1000 * seconds_between(asked_for_, *begun_);
        }
        ++figures_.pictures;
        const std::vector<InputEvent> events = screen_->poll(std::chrono::milliseconds(30));
        time_s_ = script_clock_.at(now_s());
        notices_.pass(time_s_);
        for (const InputEvent& event : events) take_while_empty(event);
        take_script_while_empty();
        for (const WindowCommand& command : std::exchange(asked_, {})) take_while_empty(command);
        if (!dropped_.empty()) open_others(std::exchange(dropped_, {}));
        note_screenshots();
        if (auto there = screen_->health(); !there.ok()) return there;
        if (options_.seconds && time_s_ >= *options_.seconds) quit_ = true;
        auto made = opening_.take();
        if (!made) continue;
        if (!made->ok())
            say(made->error().message, Tone::fault);
        else if (auto taken = take(**made); !taken.ok())
            return taken;
    }
    return {};
}

void WindowLoop::take_script_while_empty() {
    while (!quit_ && scripted_ < options_.script.size() && options_.script[scripted_].seconds <= time_s_) {
        // What is meant for the clip that was asked for waits for it.
        if (opening_.is_busy() || !dropped_.empty()) return;
        const auto& what = options_.script[scripted_++].what;
        if (const auto* const event = std::get_if<InputEvent>(&what))
            take_while_empty(*event);
        else
            take_while_empty(std::get<WindowCommand>(what));
    }
}

void WindowLoop::take_while_empty(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    events_.push_back(event);
    if (event.kind == Kind::close) quit_ = true;
    if (event.kind == Kind::dropped) dropped_.push_back(event.word);
    if (event.kind != Kind::key || event.repeated) return;
    if (const KeyBinding* const binding = binding_of(event.word, event.control, event.shift))
        take_while_empty(WindowCommand{binding->verb, binding->number, ""});
}

void WindowLoop::take_while_empty(const WindowCommand& command) {
    switch (command.verb) {
        case WindowVerb::open:
        case WindowVerb::fullscreen:
        case WindowVerb::size:
        case WindowVerb::dismiss:
        case WindowVerb::leave:
        case WindowVerb::quit:
            return take_of_window(command);
        case WindowVerb::screenshot:
            return say(keep_picture(command.word));
        default:
            return say("there is no clip yet: drop one on the window", Tone::refusal);
    }
}

}  // namespace touchable
