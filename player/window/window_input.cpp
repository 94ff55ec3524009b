// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_input.hpp"

#include <linux/input-event-codes.h>

#include <fstream>

#include "engine/base/words.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_panel.hpp"
#include "player/window/window_state.hpp"

namespace touchable {
namespace {

/// A bit of a set in the kernel's format: hexadecimal words of a `long` each, highest first.
bool has_bit(const std::filesystem::path& file, std::size_t bit) {
    std::ifstream in(file);
    std::vector<unsigned long> words;
    for (unsigned long word = 0; in >> std::hex >> word;) words.push_back(word);
    constexpr std::size_t bits = 8 * sizeof(unsigned long);
    const std::size_t number = bit / bits;
    return number < words.size() && (words[words.size() - 1 - number] >> (bit % bits) & 1U) != 0;
}

}  // namespace

bool has_touch_screen(const std::filesystem::path& inputs) {
    std::error_code failed;
    for (std::filesystem::directory_iterator at(inputs, failed), end; !failed && at != end;
         at.increment(failed))
        if (has_bit(at->path() / "properties", INPUT_PROP_DIRECT) &&
            has_bit(at->path() / "capabilities/abs", ABS_MT_POSITION_X))
            return true;
    return false;
}

std::optional<WindowCommand> WindowInput::take(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    WindowTime& time = window_.time;
    if (is_a_visit(event)) time.stirred_s = time.script_s;
    time.note_event();
    if (!first_event_) first_event_ = time.last_event;
    if (event.kind == Kind::left_window) lift_touches();
    if (!is_touch(event)) events_.push_back(event);
    if (event.kind == Kind::dropped) dropped_.push_back(event.word);
    if (event.kind == Kind::key || event.kind == Kind::key_released) return command_of(event);
    is_touch(event) ? take_touch(event) : take_pointer(event);
    return {};
}

std::optional<WindowCommand> WindowInput::command_of(const InputEvent& event) const {
    if (event.kind == InputEvent::Kind::key_released) {
        const bool ends = window_.options.hand && event.word == row_of(WindowVerb::clutch).keys.front().key;
        return ends ? std::optional(WindowCommand{WindowVerb::clutch, 0}) : std::nullopt;
    }
    if (panel_.takes_key(event)) return {};
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (!binding || (event.repeated && !row_of(binding->verb).has(CommandRow::by_steps))) return {};
    return WindowCommand{binding->verb, event.stopped_force ? -1 : binding->number, ""};
}

void WindowInput::take_pointer(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::moved) at_ = {event.x, event.y};
    if (event.kind == Kind::moved || event.kind == Kind::left_window) is_there_ = event.kind == Kind::moved;
    OpenedClip* const clip = window_.clip.get();
    const bool is_over = !pointer_.holds() && panel_.covers(at_);
    const bool is_of_panel = panel_.holds_pointer() || is_over;
    // A finger under the bar touches, though the bar has the clicks; not in an unattended window, whose
    // visitors may not know about the finger.
    const bool leaves =
        panel_.holds_pointer() || (is_over && (window_.is_unattended() || !panel_.is_bar(at_)));
    if (clip && leaves && (event.kind == Kind::moved || event.kind == Kind::pressed)) leave_picture();
    for (WindowMode* const mode : window_.modes)
        if (mode->handle_pointer(event, at_, is_of_panel)) return;
    if (clicks_for_fullscreen(event, is_of_panel)) return turn_fullscreen();
    if (!clip) return;
    const bool is_right = event.word == "right" && !is_of_panel && !window_.is_unattended();
    if (is_right && event.kind == Kind::pressed) clicked_ = at_;
    if (is_right && event.kind == Kind::released && glm::distance(at_, clicked_) < DoubleClick::farthest_px)
        panel_.menu_at = at_;
    const bool is_middle = event.word == "middle" || (event.word == "left" && event.control);
    if (event.kind == Kind::pressed && is_middle && !is_of_panel &&
        middle_click_.press(window_.time.script_s, at_))
        middle_ = at_;
    const ScreenSize size = window_.screen->size();
    const auto leads = window_.options.hand || window_.any_button(LeftButton::turns_view)
                           ? PointerInput::Leads::view
                           : PointerInput::Leads::fingers;
    // A new clip has no pointer position yet.
    if (event.kind == Kind::pressed && is_there_ && !is_of_panel)
        pointer_.take({.kind = Kind::moved, .x = at_.x, .y = at_.y}, leads, clip->fingers(), clip->view(),
                      size.width, size.height);
    const bool ends = event.kind == Kind::released || event.kind == Kind::left_window;
    if (!is_of_panel || ends || (event.kind == Kind::moved && !leaves))
        pointer_.take(event, leads, clip->fingers(), clip->view(), size.width, size.height);
}

/// The role of a new touch there. A mode's tool and the panel use it as the pointer.
TouchInput::Ground WindowInput::ground_at(double x, double y) {
    using Ground = TouchInput::Ground;
    OpenedClip* const clip = window_.clip.get();
    if (!clip || window_.any_button(LeftButton::is_a_tool) || panel_.covers({x, y})) return Ground::pointers;
    const WatchedMoment* const moment = clip->session().look();
    if (window_.options.hand || window_.any_button(LeftButton::turns_view) || !moment) return Ground::nothing;
    const ScreenSize size = window_.screen->size();
    const HeightField field(clip->scene(), moment->held.pair);
    const ViewCamera camera = clip->view().camera(size.width, size.height);
    return PointerFingers::ground_at(field, camera, {x, y}) ? Ground::surface : Ground::nothing;
}

void WindowInput::take_touch(const InputEvent& event) {
    const ScreenSize size = window_.screen->size();
    was_touched_ = true;
    const bool begins = event.kind == InputEvent::Kind::touch_began;
    const auto ground = begins ? ground_at(event.x, event.y) : TouchInput::Ground::nothing;
    OpenedClip* const clip = window_.clip.get();
    const auto led = clip ? TouchInput::Led{&clip->fingers(), &clip->view()} : TouchInput::Led{};
    take_pointers(touches_.take(event, ground, led, size.width, size.height));
}

void WindowInput::lift_touches() {
    take_pointers(touches_.cancel(window_.clip ? &window_.clip->fingers() : nullptr));
}

/// Applies the pointer events of touches.
void WindowInput::take_pointers(const std::vector<InputEvent>& events) {
    for (const InputEvent& done : events) {
        events_.push_back(done);
        take_pointer(done);
    }
}

bool WindowInput::has_slept() {
    constexpr std::chrono::milliseconds noticed(100);
    const WindowClock::duration slept = WindowClock::slept();
    return slept - std::exchange(slept_, slept) > noticed;
}

void WindowInput::leave_picture() {
    pointer_.leave(window_.clip->fingers());
}

/// The pointer leaves before the button is released.
void WindowInput::release_panel() {
    using Kind = InputEvent::Kind;
    events_.push_back(InputEvent{.kind = Kind::left_window});
    events_.push_back(InputEvent{.kind = Kind::released, .word = "left"});
    if (is_there_) events_.push_back(InputEvent{.kind = Kind::moved, .x = at_.x, .y = at_.y});
}

void WindowInput::move_by(double x, double y) {
    const ScreenSize size = window_.screen->size();
    pointer_.move_by({x, y}, size.width, size.height, window_.clip->fingers());
}

std::optional<glm::dvec2> WindowInput::pointer_over_picture() const {
    return is_there_ && !panel_.covers(at_) ? std::optional(at_) : std::nullopt;
}

bool WindowInput::has_touch_screen() const {
    static const bool is_there = touchable::has_touch_screen();
    return was_touched_ || (is_there && !window_.options.headless);
}

/// Whether this is the second of two quick presses on the picture, which presses no finger.
bool WindowInput::clicks_for_fullscreen(const InputEvent& event, bool is_of_panel) {
    if (event.kind != InputEvent::Kind::pressed) return false;
    if (event.word != "left" || event.control || is_of_panel || window_.is_unattended()) {
        fullscreen_click_.forget();
        return false;
    }
    return fullscreen_click_.press(window_.time.script_s, at_);
}

void WindowInput::turn_fullscreen() {
    if (window_.clip) {
        lift_touches();
        leave_picture();
    }
    is_fullscreen_ = !is_fullscreen_;
    window_.screen->set_fullscreen(is_fullscreen_);
}

/// True during user input, unless a finger presses where the bar is.
bool WindowInput::bar_is_wanted() const {
    constexpr double rest_s = 4;
    const auto is_bar = [this](const glm::dvec2& at) { return panel_.is_bar(at); };
    if ((pointer_.holds() && is_bar(at_)) || touches_.any_over_picture(is_bar)) return false;
    return window_.time.script_s - window_.time.stirred_s < rest_s || panel_.holds_pointer();
}

void WindowInput::go_on() {
    const OpenedClip& clip = *window_.clip;
    const bool is_held = window_.options.hand != nullptr, has_bar = bar_is_wanted();
    panel_.bar_shown = has_bar;
    const bool is_finger = !is_held && clip.shown() > 0 && clip.force_is_on() &&
                           !window_.any_button(LeftButton::is_a_tool) &&
                           !window_.any_button(LeftButton::turns_view);
    window_.screen->hide_pointer((is_finger && !panel_.covers(at_)) || (is_held && !has_bar));
}

}  // namespace touchable
