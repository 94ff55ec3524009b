#include "player/window/window_input.hpp"

#include <linux/input-event-codes.h>

#include <fstream>

#include "engine/base/words.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_core.hpp"

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

void WindowInput::take(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    WindowTime& time = core_.time;
    if (is_a_visit(event)) time.stirred_s = time.script_s;
    time.note_event();
    if (!first_event_) first_event_ = time.last_event;
    if (is_touch(event)) return take_touch(event);
    if (event.kind == Kind::left_window) lift_touches();
    events_.push_back(event);
    if (event.kind == Kind::close) core_.close();
    if (event.kind == Kind::dropped) dropped_.push_back(event.word);
    if (event.kind == Kind::key || event.kind == Kind::key_released) return take_key(event);
    take_pointer(event);
}

void WindowInput::take_key(const InputEvent& event) {
    if (event.kind == InputEvent::Kind::key_released) {
        for (const KeyBinding& binding : key_bindings())
            if (core_.options.hand && event.word == binding.key && binding.verb == WindowVerb::clutch)
                core_.take(WindowCommand{WindowVerb::clutch, 0});
        return;
    }
    if (core_.picture().panel().takes_key(event)) return;
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (binding && (!event.repeated || row_of(binding->verb).has(CommandRow::by_steps)))
        core_.take(WindowCommand{binding->verb, event.stopped_force ? -1 : binding->number, ""});
}

void WindowInput::take_pointer(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::moved) at_ = {event.x, event.y};
    if (event.kind == Kind::moved || event.kind == Kind::left_window) is_there_ = event.kind == Kind::moved;
    const WindowPicture& picture = core_.picture();
    OpenedClip* const clip = core_.clip();
    const bool is_over = !pointer_.holds() && picture.panel_covers(at_);
    const bool is_of_panel = picture.holds_pointer() || is_over;
    // A finger under the bar touches, though the bar has the clicks; not in an unattended window, whose
    // visitors may not know about the finger.
    const bool leaves =
        picture.holds_pointer() || (is_over && (core_.is_unattended() || !picture.is_bar(at_)));
    if (clip && leaves && (event.kind == Kind::moved || event.kind == Kind::pressed)) leave_picture();
    for (WindowMode* const mode : core_.modes())
        if (mode->handle_pointer(event, is_of_panel)) return;
    if (clicks_for_fullscreen(event, is_of_panel)) return turn_fullscreen();
    if (!clip) return;
    const bool is_right = event.word == "right" && !is_of_panel && !core_.is_unattended();
    if (is_right && event.kind == Kind::pressed) clicked_ = at_;
    if (is_right && event.kind == Kind::released && glm::distance(at_, clicked_) < DoubleClick::farthest_px)
        core_.picture().panel().menu_at = at_;
    const ScreenSize size = core_.screen().size();
    const auto leads = core_.options.hand || core_.any_button(LeftButton::turns_view)
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
    OpenedClip* const clip = core_.clip();
    if (!clip || core_.any_button(LeftButton::is_a_tool) || core_.picture().panel_covers({x, y}))
        return Ground::pointers;
    const WatchedMoment* const moment = clip->session().look();
    if (core_.options.hand || core_.any_button(LeftButton::turns_view) || !moment) return Ground::nothing;
    const ScreenSize size = core_.screen().size();
    const HeightField field(clip->scene(), moment->held.pair);
    const ViewCamera camera = clip->view().camera(size.width, size.height);
    return PointerFingers::ground_at(field, camera, {x, y}) ? Ground::surface : Ground::nothing;
}

void WindowInput::take_touch(const InputEvent& event) {
    const ScreenSize size = core_.screen().size();
    was_touched_ = true;
    const bool begins = event.kind == InputEvent::Kind::touch_began;
    const auto ground = begins ? ground_at(event.x, event.y) : TouchInput::Ground::nothing;
    OpenedClip* const clip = core_.clip();
    const auto led = clip ? TouchInput::Led{&clip->fingers(), &clip->view()} : TouchInput::Led{};
    take_pointers(touches_.take(event, ground, led, size.width, size.height));
}

void WindowInput::lift_touches() {
    take_pointers(touches_.cancel(core_.clip() ? &core_.clip()->fingers() : nullptr));
}

/// Applies the pointer events of touches.
void WindowInput::take_pointers(const std::vector<InputEvent>& events) {
    for (const InputEvent& done : events) {
        events_.push_back(done);
        take_pointer(done);
    }
}

void WindowInput::lift_after_sleep() {
    constexpr std::chrono::milliseconds noticed(100);
    const WindowClock::duration slept = WindowClock::slept();
    if (slept - std::exchange(slept_, slept) > noticed)
        core_.take(InputEvent{.kind = InputEvent::Kind::left_window});
}

void WindowInput::leave_picture() {
    pointer_.leave(core_.clip()->fingers());
}

/// The pointer leaves before the button is released.
void WindowInput::release_panel() {
    using Kind = InputEvent::Kind;
    events_.push_back(InputEvent{.kind = Kind::left_window});
    events_.push_back(InputEvent{.kind = Kind::released, .word = "left"});
    if (is_there_) events_.push_back(InputEvent{.kind = Kind::moved, .x = at_.x, .y = at_.y});
}

void WindowInput::move_by(double x, double y) {
    const ScreenSize size = core_.screen().size();
    pointer_.move_by({x, y}, size.width, size.height, core_.clip()->fingers());
}

std::optional<glm::dvec2> WindowInput::pointer_over_picture() const {
    return is_there_ && !core_.picture().panel_covers(at_) ? std::optional(at_) : std::nullopt;
}

bool WindowInput::has_touch_screen() const {
    static const bool is_there = touchable::has_touch_screen();
    return was_touched_ || (is_there && !core_.options.headless);
}

/// Whether this is the second of two quick presses on the picture, which presses no finger.
bool WindowInput::clicks_for_fullscreen(const InputEvent& event, bool is_of_panel) {
    if (event.kind != InputEvent::Kind::pressed) return false;
    if (event.word != "left" || event.control || is_of_panel || core_.is_unattended()) {
        fullscreen_click_.forget();
        return false;
    }
    return fullscreen_click_.press(core_.time.script_s, at_);
}

void WindowInput::turn_fullscreen() {
    if (core_.clip()) {
        lift_touches();
        leave_picture();
    }
    is_fullscreen_ = !is_fullscreen_;
    core_.screen().set_fullscreen(is_fullscreen_);
}

/// True during user input, unless a finger presses where the bar is.
bool WindowInput::bar_is_wanted() const {
    constexpr double rest_s = 4;
    const WindowPicture& picture = core_.picture();
    const auto is_bar = [&picture](const glm::dvec2& at) { return picture.is_bar(at); };
    if ((pointer_.holds() && is_bar(at_)) || touches_.any_over_picture(is_bar)) return false;
    return core_.time.script_s - core_.time.stirred_s < rest_s || picture.holds_pointer();
}

void WindowInput::go_on() {
    const OpenedClip& clip = *core_.clip();
    const bool is_held = core_.options.hand != nullptr, has_bar = bar_is_wanted();
    core_.picture().panel().bar_shown = has_bar;
    const bool is_finger = !is_held && clip.shown() > 0 && clip.force_is_on() &&
                           !core_.any_button(LeftButton::is_a_tool) &&
                           !core_.any_button(LeftButton::turns_view);
    core_.screen().hide_pointer((is_finger && !core_.picture().panel_covers(at_)) || (is_held && !has_bar));
}

}  // namespace touchable
