#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/base/try.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/window_loop.hpp"

// What commands do to the window.

namespace touchable {

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
    if (heard.ok()) next_is_paused_ = pauses;
    say(heard);
}

void WindowLoop::take_of_view(const WindowCommand& command) {
    WindowView& view = clip_->view();
    if (command.verb == WindowVerb::home) {
        view.go_home();
        is_turning_ = false;  // whoever is back touches again
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

/// Instead of whatever else the left button does. A finger that presses leaves: nobody would lift it.
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
            if (auto drawn = draw_newest(); !drawn.ok()) return say(drawn);
            return say(keep_picture(command.word));
        case WindowVerb::open:
            return open_others({command.word});
        case WindowVerb::reset:
            return reset();
        default:
            quit_ = true;
    }
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

/// While somebody does something; but not over a finger that presses where it is.
bool WindowLoop::bar_is_wanted() const {
    constexpr double rest_s = 4;
    const auto is_bar = [this](const glm::dvec2& at) { return panel_->is_bar(at.x, at.y); };
    if ((pointer_.holds() && is_bar(pointer_at_)) || touches_.any_over_picture(is_bar)) return false;
    return time_s_ - stirred_s_ < rest_s || layer_->holds_pointer();
}

void WindowLoop::set_overlay(const std::string& name) {
    if (kiosk_ && name.empty()) return picture_.set_overlay(overlay_for_visitors(picture_.overlay()));
    const auto overlay = overlay_after(picture_.overlay(), name);
    if (!overlay.ok()) return say(overlay.error());
    picture_.set_overlay(*overlay);
}

/// One that comes when the clip is about to go is not for the next one.
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

/// What it says, and what of it is to be felt: by the road of other settings.
void WindowLoop::heed_brush() {
    const WindowBrush::News news = brush_.take_news();
    WindowSettings wanted = wanted_settings_.value_or(settings_);
    for (const auto& [words, tone, is_change] : news.remarks)
        say(words + (is_change && !has_materials(wanted) ? "; B feels it" : ""), tone);
    if (news.has_begun) compare_with_before();
    if (!news.is_another) return;
    wanted = wanted_settings_.value_or(settings_);
    wanted.painted = brush_.felt();
    if (!(wanted == wanted_settings_.value_or(settings_))) wanted_settings_ = std::move(wanted);
}

/// The set of settings that is not in effect becomes that which is, without materials: one key compares.
void WindowLoop::compare_with_before() {
    WindowSettings wanted = wanted_settings_.value_or(settings_);
    TwoSettings& two = wanted.in_effect;
    SessionSettings before = two.now();
    (void)before.set("materials", "off");
    if (two.b_is_on)
        two.a = before;
    else
        two.b = before;
    wanted_settings_ = std::move(wanted);
}

void WindowLoop::feel(const WindowCommand& command) {
    WindowSettings wanted = wanted_settings_.value_or(settings_);
    const std::size_t space = command.word.find(' ');
    const SessionSetting* const setting = session_setting(command.word.substr(0, space));
    if (setting && setting->of_device && !options_.hand)
        return say(std::string(setting->name) + " is of a device that is held; there is none", Tone::refusal);
    if (setting && setting->of_brush && !wanted.painted)
        return say("nothing is painted yet; P takes the brush of materials", Tone::refusal);
    const bool to_b = command.word.empty() ? !wanted.in_effect.b_is_on : command.word == "b";
    for (TwoSettings* const settings : {&wanted.kept, &wanted.in_effect}) {
        if (setting && setting->of_brush && settings == &wanted.kept) continue;
        if (command.verb == WindowVerb::settings) {
            settings->turn_to(to_b);
        } else if (auto set = settings->set(command.word.substr(0, space), command.word.substr(space + 1));
                   !set.ok()) {
            return say(set.error());
        }
    }
    wanted_settings_ = wanted;
}

void WindowLoop::reset() {
    WindowSettings anew;
    anew.painted = wanted_settings_.value_or(settings_).painted;
    wanted_settings_ = anew;
    if (anew.painted) compare_with_before();
    panel_->shown = false;
    is_dented_ = KeptSettings().dent;
    clip_->fingers().set_count(KeptSettings().fingers);
    sound_->set_volume(KeptSettings().volume);
    picture_.set_overlay(Overlay::colour);
    measure_.let_go();
    if (!fullscreen_) screen_->set_size(options_.screen.width, options_.screen.height);
}

KeptSettings WindowLoop::to_keep() const {
    KeptSettings kept = settings_file_.read();
    kept.panel = panel_->shown;
    if (!options_.dent) kept.dent = is_dented_;
    kept.fingers = clip_->fingers().count();
    kept.volume = sound_->volume();
    if (!options_.filters_are_stated) {
        const TwoSettings settings = wanted_settings_.value_or(settings_).kept;
        kept.a = settings.a;
        kept.b = settings.b;
    }
    const ScreenSize size = screen_->size();
    if (options_.size_is_stated || fullscreen_ || size.width < 1) return kept;
    kept.width = std::max(static_cast<int>(std::lround(size.width / size.scale)), SettingsFile::least_width);
    kept.height =
        std::max(static_cast<int>(std::lround(size.height / size.scale)), SettingsFile::least_height);
    return kept;
}

Result<void> WindowLoop::keep_picture(const std::filesystem::path& name) {
    TRY_ASSIGN(auto image, picture_.graphics().picture());
    return screenshots_.keep(std::move(image), name);
}

}  // namespace touchable
