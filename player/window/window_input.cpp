// What a person does: events of mouse, keys and touch screens, a device that is held, and commands.

#include "player/window/window_loop.hpp"

#include <linux/input-event-codes.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/base/words.hpp"
#include "player/draw/view.hpp"
#include "player/window/keys.hpp"

namespace touchable {
namespace {

bool needs_clip(WindowVerb verb) {
    using enum WindowVerb;
    return !is_one_of(verb, {next, previous, mute, volume, louder, help, dismiss, leave, fullscreen, size,
                             screenshot, open, quit});
}

/// A bit of a set as the kernel prints it: words of a `long` each in hexadecimal, the highest first.
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

void WindowLoop::take(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    const bool is_of_study = study_ && clip_ && event.kind == Kind::key;
    if (kiosk_ && !is_for_visitors(event) && !is_of_study) return;
    if (kiosk_ && clip_ && is_a_visit(event)) welcome(event);
    if (study_ && clip_ && take_of_study(event)) return;
    if (is_a_visit(event)) stirred_s_ = time_s_;
    last_event_ = Clock::now();
    if (!first_event_) first_event_ = last_event_;
    if (is_touch(event)) return take_of_touch(event);
    if (event.kind == Kind::left_window) lift_touches();
    events_.push_back(event);
    if (event.kind == Kind::close) {
        leaves_at_once_ = quit_;
        quit_ = true;
    }
    if (event.kind == Kind::dropped) dropped_.push_back(event.word);
    if (event.kind == Kind::key) {
        const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
        if (binding && (!event.repeated || goes_by_steps(binding->verb)))
            take(WindowCommand{binding->verb, event.stopped_force ? -1 : binding->number, ""});
        return;
    }
    if (event.kind == Kind::key_released) {
        for (const KeyBinding& binding : key_bindings())
            if (event.word == binding.key && binding.verb == WindowVerb::clutch)
                take(WindowCommand{WindowVerb::clutch, 0});
        return;
    }
    take_of_pointer(event);
}

void WindowLoop::take_of_pointer(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::moved) pointer_at_ = {event.x, event.y};
    if (event.kind == Kind::moved || event.kind == Kind::left_window)
        pointer_is_there_ = event.kind == Kind::moved;
    const bool is_over = !pointer_.holds() && panel_->covers(pointer_at_.x, pointer_at_.y);
    const bool is_of_panel = layer_->holds_pointer() || is_over;
    // A finger under the bar is felt, though the bar has the clicks; not in a kiosk, where some never knew
    // that a finger is there.
    const bool leaves =
        layer_->holds_pointer() || (is_over && (kiosk_ || !panel_->is_bar(pointer_at_.x, pointer_at_.y)));
    if (clip_ && leaves && (event.kind == Kind::moved || event.kind == Kind::pressed))
        pointer_.leave(clip_->fingers());
    const ScreenSize size = screen_->size();
    if (!is_of_panel && measure_.take(event, pointer_at_)) return;
    if (clip_ && brush_.take(event, pointer_at_, is_of_panel, size)) return;
    if (clicks_for_full_screen(event, is_of_panel)) return turn_full_screen();
    if (!clip_) return;
    const auto leads =
        options_.hand || is_turning_ ? PointerInput::Leads::view : PointerInput::Leads::fingers;
    // A clip that has just come knows of no pointer yet.
    if (event.kind == Kind::pressed && pointer_is_there_ && !is_of_panel)
        pointer_.take({.kind = Kind::moved, .x = pointer_at_.x, .y = pointer_at_.y}, leads, clip_->fingers(),
                      clip_->view(), size.width, size.height);
    const bool ends = event.kind == Kind::released || event.kind == Kind::left_window;
    if (!is_of_panel || ends || (event.kind == Kind::moved && !leaves))
        pointer_.take(event, leads, clip_->fingers(), clip_->view(), size.width, size.height);
}

/// What a finger that comes down there is for. A brush, a measure and the panel take it for the pointer.
TouchInput::Ground WindowLoop::ground_at(double x, double y) {
    using Ground = TouchInput::Ground;
    if (!clip_ || brush_.is_held() || measure_.is_held() || panel_->covers(x, y)) return Ground::pointers;
    const WatchedMoment* const moment = clip_->session().look();
    if (options_.hand || is_turning_ || !moment) return Ground::nothing;
    const ScreenSize size = screen_->size();
    const HeightField field(clip_->scene(), moment->held.pair);
    const ViewCamera camera = clip_->view().camera(size.width, size.height);
    return PointerFingers::ground_at(field, camera, {x, y}) ? Ground::surface : Ground::nothing;
}

void WindowLoop::take_of_touch(const InputEvent& event) {
    const ScreenSize size = screen_->size();
    was_touched_ = true;
    const bool begins = event.kind == InputEvent::Kind::touch_began;
    const auto ground = begins ? ground_at(event.x, event.y) : TouchInput::Ground::nothing;
    const auto led = clip_ ? TouchInput::Led{&clip_->fingers(), &clip_->view()} : TouchInput::Led{};
    for (const InputEvent& done : touches_.take(event, ground, led, size.width, size.height)) {
        events_.push_back(done);
        take_of_pointer(done);
    }
}

/// Whatever they do: the window is looked at no more, or the clip goes.
void WindowLoop::lift_touches() {
    for (const InputEvent& done : touches_.cancel(clip_ ? &clip_->fingers() : nullptr)) {
        events_.push_back(done);
        take_of_pointer(done);
    }
}

/// After a machine was suspended it is not known what is still pressed. Lifts all fingers and buttons that
/// were down; the force of a finger that comes down again begins at zero.
void WindowLoop::lift_after_sleep() {
    constexpr std::chrono::milliseconds noticed(100);
    const Clock::duration slept = Clock::slept();
    if (slept - std::exchange(slept_, slept) > noticed)
        take(InputEvent{.kind = InputEvent::Kind::left_window});
}

/// As far as is known.
bool WindowLoop::has_touch_screen() const {
    static const bool is_there = touchable::has_touch_screen();
    return was_touched_ || (is_there && !options_.headless);
}

/// The second of two quick presses on the picture presses no finger.
bool WindowLoop::clicks_for_full_screen(const InputEvent& event, bool is_of_panel) {
    if (event.kind != InputEvent::Kind::pressed) return false;
    if (event.word != "left" || event.control || is_of_panel || kiosk_) {
        full_screen_click_.forget();
        return false;
    }
    return full_screen_click_.press(time_s_, pointer_at_);
}

/// Fingers leave: the pointer is over another place then, to which a pressed one would be torn.
void WindowLoop::turn_full_screen() {
    if (clip_) {
        lift_touches();
        pointer_.leave(clip_->fingers());
    }
    fullscreen_ = !fullscreen_;
    screen_->set_fullscreen(fullscreen_);
}

/// While a person does something, but not over a finger that presses where the bar is.
bool WindowLoop::bar_is_wanted() const {
    constexpr double rest_s = 4;
    const auto is_bar = [this](const glm::dvec2& at) { return panel_->is_bar(at.x, at.y); };
    if ((pointer_.holds() && is_bar(pointer_at_)) || touches_.any_over_picture(is_bar)) return false;
    return time_s_ - stirred_s_ < rest_s || layer_->holds_pointer();
}

void WindowLoop::take(const WindowCommand& command) {
    last_event_ = Clock::now();
    if (!clip_ && needs_clip(command.verb)) return refuse_without_clip();
    switch (command.verb) {
        case WindowVerb::play_pause:
        case WindowVerb::seek_by:
        case WindowVerb::seek_to:
        case WindowVerb::step:
        case WindowVerb::faster:
        case WindowVerb::speed:
        case WindowVerb::loop:
            return take_of_time(command);
        case WindowVerb::home:
        case WindowVerb::turn:
        case WindowVerb::tilt:
        case WindowVerb::turning:
        case WindowVerb::nearer:
            return take_of_view(command);
        case WindowVerb::fingers:
        case WindowVerb::deeper:
        case WindowVerb::point_right:
        case WindowVerb::point_down:
        case WindowVerb::force:
            return options_.hand ? take_of_hand(command) : take_of_fingers(command);
        case WindowVerb::clutch:
        case WindowVerb::recentre:
        case WindowVerb::coarser:
            if (options_.hand) return take_of_hand(command);
            return say("the finger is the mouse's; a device that is held can do that");
        case WindowVerb::feel:
        case WindowVerb::settings:
            return feel(command);
        case WindowVerb::mute:
        case WindowVerb::volume:
        case WindowVerb::louder:
            return take_of_sound(command);
        case WindowVerb::tool:
        case WindowVerb::material:
        case WindowVerb::paint:
        case WindowVerb::join:
        case WindowVerb::cut:
        case WindowVerb::otherwise:
        case WindowVerb::undo:
        case WindowVerb::redo:
        case WindowVerb::save_materials:
            return take_of_brush(command);
        case WindowVerb::measure:
            return take_of_measure(command);
        case WindowVerb::go_on:
        case WindowVerb::answer:
            return take_of_study(command);
        default:
            return take_of_window(command);
    }
}

/// A visitor gets no message: the clip is soon there.
void WindowLoop::refuse_without_clip() {
    if (!kiosk_)
        say(opening_.is_busy() ? "there is no clip yet" : "there is no clip yet: drop one on the window",
            Tone::refusal);
}

void WindowLoop::take_of_time(const WindowCommand& command) {
    switch (command.verb) {
        case WindowVerb::play_pause:
            return play_or_pause();
        case WindowVerb::seek_by:
            return playback_->seek_by(command.number);
        case WindowVerb::seek_to:
            return playback_->seek_to(command.number);
        case WindowVerb::step:
            return say(playback_->step(command.number));
        case WindowVerb::faster:
            return say(playback_->change_speed(command.number));
        case WindowVerb::speed:
            return say(playback_->set_speed(command.number));
        default:
            return say(playback_->toggle_loop());
    }
}

/// While another clip is on its way, that one is meant; the one that is there shows that the press was heard.
void WindowLoop::play_or_pause() {
    if (!next_is_paused_) return say(playback_->play_or_pause());
    const PlaybackState there = clip_->session().playback();
    // What the button shows: at the end it is "play", but in a kiosk, which goes on there by itself.
    const bool pauses = there.playing && (kiosk_ || !there.at_end);
    const Result<void> heard = playback_->pause(pauses);
    if (heard) next_is_paused_ = pauses;
    say(heard);
}

void WindowLoop::take_of_view(const WindowCommand& command) {
    WindowView& view = clip_->view();
    if (command.verb == WindowVerb::home) {
        view.go_home();
        is_turning_ = false;  // dragging touches again
    }
    if (command.verb == WindowVerb::turn) view.turn(command.number, 0);
    if (command.verb == WindowVerb::tilt) view.turn(0, command.number);
    if (command.verb == WindowVerb::nearer) view.near_by(command.number);
    if (command.verb != WindowVerb::turning) return;
    if (options_.hand) return say("dragging turns the view already");
    set_turning(!is_turning_);
    say(is_turning_ ? "drag: the view turns; with the right button it moves; the wheel comes nearer"
                    : "the left button presses the finger again");
}

/// Dragging turns the view instead of what the left button did. A finger that presses leaves, as no event
/// would lift it.
void WindowLoop::set_turning(bool on) {
    is_turning_ = on;
    if (!on) return;
    pointer_.leave(clip_->fingers());
    clip_->fingers().lift();
    measure_.hold(false);
    if (brush_.is_held()) take(WindowCommand{.verb = WindowVerb::tool, .word = name_of(BrushTool::touch)});
}

void WindowLoop::take_of_fingers(const WindowCommand& command) {
    PointerFingers& fingers = clip_->fingers();
    const ScreenSize size = screen_->size();
    switch (command.verb) {
        case WindowVerb::fingers:
            return fingers.set_count(static_cast<int>(command.number));
        case WindowVerb::deeper:
            return fingers.deepen(command.number / 1000);
        case WindowVerb::point_right:
            return pointer_.move_by({command.number, 0}, size.width, size.height, fingers);
        case WindowVerb::point_down:
            return pointer_.move_by({0, command.number}, size.width, size.height, fingers);
        default:
            clip_->set_force(command.number == 0 && !clip_->force_is_on());
            return say(clip_->force_is_on() ? "force on" : "force off");
    }
}

void WindowLoop::take_of_window(const WindowCommand& command) {
    switch (command.verb) {
        case WindowVerb::overlay:
            return set_overlay(command.word);
        case WindowVerb::next:
            return go_in_list(1);
        case WindowVerb::previous:
            return go_in_list(-1);
        case WindowVerb::panel:
            panel_->shown = !panel_->shown;
            return;
        case WindowVerb::dent:
            is_dented_ = command.number > 0;
            return;
        case WindowVerb::help:
            panel_->help_shown = !panel_->help_shown;
            return;
        case WindowVerb::dismiss:
            notices_.dismiss();
            return;
        case WindowVerb::leave:
            quit_ = quit_ || !leave_what_is_in_front();
            return;
        case WindowVerb::fullscreen:
            return turn_full_screen();
        case WindowVerb::size:
            return screen_->set_size(command.width, command.height);
        case WindowVerb::screenshot:
            if (auto drawn = draw_newest(); !drawn) return say(drawn);
            return say(keep_picture(command.word));
        case WindowVerb::open:
            return open_others({command.word});
        case WindowVerb::reset:
            return reset();
        default:
            quit_ = true;
    }
}

void WindowLoop::set_overlay(const std::string& name) {
    if (kiosk_ && name.empty()) return picture_.set_overlay(overlay_for_visitors(picture_.overlay()));
    const auto overlay = overlay_after(picture_.overlay(), name);
    if (!overlay) return say(overlay.error());
    picture_.set_overlay(*overlay);
}

/// Help, a fault, the measure, turning, the brush, full screen: one of them, from front to back. Whether
/// there was any.
bool WindowLoop::leave_what_is_in_front() {
    if (std::exchange(panel_->help_shown, false) || notices_.dismiss()) return true;
    notices_.clear_passing();  // the hint of a tool that is put away
    if (measure_.is_held() || measure_.has_line())
        measure_.let_go();
    else if (is_turning_)
        is_turning_ = false;
    else if (brush_.is_held())
        take(WindowCommand{.verb = WindowVerb::tool, .word = name_of(BrushTool::touch)});
    else if (fullscreen_)
        turn_full_screen();
    else
        return false;
    return true;
}

void WindowLoop::take_of_sound(const WindowCommand& command) {
    if (command.verb == WindowVerb::mute) {
        sound_->set_muted(!sound_->is_muted());
        return say(sound_->state());
    }
    const double before = command.verb == WindowVerb::louder ? sound_->volume() : 0;
    sound_->set_volume(static_cast<int>(std::lround(before + command.number)));
    say("volume " + std::to_string(sound_->volume()) + " %" + (sound_->is_muted() ? "; M: sound on" : ""));
}

void WindowLoop::take_of_measure(const WindowCommand& command) {
    if (command.word == "off") return measure_.let_go();
    if (command.places.empty()) {
        measure_.hold(!measure_.is_held());
        if (measure_.is_held()) set_turning(false);
        if (measure_.is_held() && brush_.is_held())
            take(WindowCommand{.verb = WindowVerb::tool, .word = name_of(BrushTool::touch)});
        if (measure_.is_held())
            say("measure: click two places of the surface, or drag from one to the other");
        return;
    }
    const Scene& scene = clip_->scene();
    for (const PixelOfFrame& place : command.places)
        if (place.x >= scene.width || place.y >= scene.height)
            return say("measure: there is no pixel " + std::to_string(place.x) + ", " +
                           std::to_string(place.y) + "; the depth has " + std::to_string(scene.width) + "x" +
                           std::to_string(scene.height),
                       Tone::refusal);
    measure_.set({command.places[0].x, command.places[0].y}, {command.places[1].x, command.places[1].y});
    const ScreenSize size = screen_->size();
    if (const WatchedMoment* const newest = clip_->session().look())
        measure(*newest, HeightField(scene, newest->held.pair),
                clip_->view().camera(size.width, size.height));
}

/// What is measured in the picture of this moment.
void WindowLoop::measure(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera) {
    const FramePair& pair = moment.held.pair;
    const bool is_there = pointer_is_there_ && !panel_->covers(pointer_at_.x, pointer_at_.y);
    measure_.look({.field = field,
                   .pair = pair,
                   .camera = camera,
                   .stored = moment.stored ? moment.stored->depth : PlaneView{},
                   .frame = pair.blend < 0.5 ? pair.prev.number : pair.next.number,
                   .pointer = is_there ? std::optional(pointer_at_) : std::nullopt});
    constexpr std::size_t most_told = 1000;
    for (MeasureTool::News& news : measure_.take_news()) {
        if (news.is_bad)
            say(std::move(news.words), Tone::refusal);
        else if (measured_.size() < most_told)
            measured_.push_back(std::move(news.words));
    }
}

/// Refuses the brush's commands when the clip is about to go: they are not meant for the next one.
void WindowLoop::take_of_brush(const WindowCommand& command) {
    if (quit_ || (ready_ && ready_->clip))
        return say("the clip is about to go; nothing is painted any more", Tone::refusal);
    brush_.take(command);
    if (brush_.is_held()) {
        measure_.hold(false);
        set_turning(false);
    }
    if (brush_.is_held() && (command.verb == WindowVerb::tool || command.verb == WindowVerb::material))
        panel_->shown = true;
    heed_brush();
}

void WindowLoop::take_of_hand(const WindowCommand& command) {
    PersistentDevice& hand = *options_.hand;
    switch (command.verb) {
        case WindowVerb::force:
            // The device comes back without forces: its user may have left by then.
            if (hand.is_gone()) {
                clip_->set_force(false);
                return hand.look_again();
            }
            // Forces are not asked for while the device is away: they would come without warning when it is
            // back.
            if (command.number == 0 && !clip_->force_is_on() && !(hand.age_s() <= HapticDevice::oldest_s))
                return say("no forces yet: no position comes from the " + hand.name());
            return clip_->set_force(command.number == 0 && !clip_->force_is_on());
        case WindowVerb::clutch:
            return clip_->control()->hold(command.number != 0);
        case WindowVerb::recentre:
            clip_->control()->recentre();
            return say("the middle is where the hand is");
        case WindowVerb::coarser:
            return change_scale(command.number);
        default:
            return say("the fingers are those of the " + hand.name());
    }
}

/// A setting like the others, by steps.
void WindowLoop::change_scale(double times) {
    const char* const name = "hand-scale";
    const auto chosen = wanted_settings().in_effect.now().values();
    const auto found = chosen.find(name);
    const std::string now = found != chosen.end() ? found->second : clip_->in_effect().at(name);
    const SettingRange& range = session_setting(name)->range;
    const double scale = std::clamp(parsed_number(now).value_or(1) * times, range.least, range.most);
    feel({WindowVerb::feel, 0, name + (" " + std::to_string(scale))});
}

/// Called once a turn. (HandControl switches forces off after a second without a user.)
void WindowLoop::look_after_hand(const WatchedMoment* moment) {
    PersistentDevice& hand = *options_.hand;
    if (const bool gone = hand.is_gone(); gone != std::exchange(hand_is_gone_, gone) && gone) {
        last_event_ = Clock::now();
        if (const auto health = hand.health(); !health) {
            const std::string fault = options_.names.error(health.error());
            log_fault(fault);
            tell(fault);
        }
    }
    if (!kiosk_ || !moment || moment->felt.fingers.empty()) return;
    const glm::dvec3 goal = moment->felt.fingers[0].goal, way = goal - hand_seen_at_;
    const double far = clip_->sizes().finger_radius / 2;
    if (glm::dot(way, way) < far * far || !(glm::dot(goal, goal) >= 0)) return;
    hand_seen_at_ = goal;
    // Another clip, or one that has begun anew, maps a hand that rests to another place of its world.
    constexpr double mapped_s = 0.5;
    if (now_s() > begun_anew_s_ + mapped_s) kiosk_->came(now_s());
}

/// Takes the power off as the window ends. Forces are no longer asked for, too, so that the session's last
/// ticks are recorded as the hand had them.
void WindowLoop::power_hand_off() {
    if (!options_.hand) return;
    options_.hand->power_off();
    if (clip_) clip_->set_force(false);
}

/// The screen's thread calls it: F takes forces off while the main thread draws or waits. F where forces are
/// off asks for them, which is the main thread's.
void WindowLoop::stop_force_at_once(InputEvent& event) {
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (!binding || binding->verb != WindowVerb::force || event.repeated) return;
    if (options_.study && !options_.hand) return;  // a participant's mouse has no such key
    const std::lock_guard lock(force_mutex_);
    if (force_givers_.control && force_givers_.control->force_is_asked()) {
        force_givers_.control->ask_force(false);
        event.stopped_force = true;
    } else if (!force_givers_.control && force_givers_.pointer && force_givers_.pointer->force_is_on()) {
        force_givers_.pointer->set_force(false);
        event.stopped_force = true;
    }
}

/// From now on stop_force_at_once stops the newest session of the clip. A key that came between that
/// session's begin and this call has stopped the session before; the main thread then stops this one, as for
/// every key.
void WindowLoop::lead_force() {
    const std::lock_guard lock(force_mutex_);
    force_givers_ = {clip_->shared_device(), clip_->session().setup().control};
}

}  // namespace touchable
