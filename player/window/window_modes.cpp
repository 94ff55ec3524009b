// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_modes.hpp"

#include "player/run/terminal.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/window_clips.hpp"
#include "player/window/window_input.hpp"
#include "player/window/window_panel.hpp"
#include "player/window/window_state.hpp"

namespace touchable {

// --- The view

void ViewMode::go_home() {
    window_.clip->view().go_home();
    is_turning_ = false;
}

/// Lifts a pressing finger, as no release would arrive.
void ViewMode::turn_or_touch() {
    if (window_.options.hand) return window_.say("dragging turns the view already");
    is_turning_ = !is_turning_;
    if (is_turning_) {
        input_.leave_picture();
        window_.clip->fingers().lift();
        window_.take_button(*this);
    }
    window_.say(is_turning_ ? "drag: the view turns; with the right button it moves; the wheel zooms"
                            : "the left button presses the finger again");
}

void ViewMode::begin_clip(bool goes_on) {
    is_turning_ = is_turning_ && goes_on;
    before_.clear();
    seen_ = window_.clip->view().state();
}

void ViewMode::go_on(double) {
    constexpr double burst_s = 0.6;
    constexpr std::size_t most = 32;
    const WindowView::State& state = window_.clip->view().state();
    const double now_s = window_.time.script_s;
    const bool goes_on = !before_.empty() && now_s - changed_s_ < burst_s;
    const bool is_changed = !state.looks_as(seen_);
    if (is_changed && !goes_on) before_.push_back(seen_);
    if (before_.size() > most) before_.pop_front();
    if (is_changed || (goes_on && input_.holds())) changed_s_ = now_s;  // a drag may rest
    if (is_changed) seen_ = state;
}

void ViewMode::undo() {
    go_on(0);
    if (before_.empty()) return window_.say("the view has not been turned, moved or zoomed", Tone::refusal);
    window_.clip->view().set_state(before_.back());
    seen_ = std::move(before_.back());
    before_.pop_back();
    changed_s_ = -1e9;  // the next change is another gesture
}

// --- The list of clips

void PlaylistMode::go(int by) {
    if (!window_.clip && !clips_.waits_for_wish()) return;  // the first clip is not open yet
    Playlist list = clips_.wanted_list();
    if (list.go(by)) return clips_.open_instead(std::move(list), by);
    if (list.size() < 2) return window_.say("there is no other clip; drop some on the window");
    window_.say("this is the " + std::string(by > 0 ? "last" : "first") + " of " +
                std::to_string(list.size()) + " clips");
}

/// By the user.
bool PlaylistMode::is_touched() const {
    if (window_.any_button(LeftButton::is_a_tool) || panel_.holds_pointer()) return true;
    if (window_.any(&WindowMode::moves_by_itself)) return false;
    WatchedSession& session = window_.clip->session();
    const WatchedMoment* const moment = session.look();
    return input_.holds_pointer() ||
           (moment && session.running() &&
            std::ranges::any_of(moment->felt.fingers,
                                [](const WatchedTick::Finger& finger) { return finger.contact.touching; }));
}

void PlaylistMode::go_on(double) {
    constexpr double blink_s = 1, rest_s = 5, again_s = 1, between_strokes_s = 3;
    const double now_s = window_.time.script_s;
    if (is_touched()) touched_s_ = now_s;
    const OpenedClip& clip = *window_.clip;
    const PlaybackState playback = clip.session().playback();
    const bool has_ended = playback.at_end && playback.playing && !playback.loops;
    if (!has_ended) return went_on_s_.reset();
    if (window_.any(&WindowMode::chooses_clip) || clips_.list().size() < 2 || clips_.is_busy()) return;
    if (clip.seconds() < blink_s && now_s < shown_s_ + rest_s) return;
    // If no other clip opens, it is reported once; an unattended window retries.
    if (went_on_s_ && (!window_.is_unattended() || now_s < *went_on_s_ + again_s)) return;
    if (touched_s_ && now_s < *touched_s_ + between_strokes_s) return;
    went_on_s_ = now_s;
    Playlist list = clips_.list();
    if (list.go(1)) clips_.open_instead(std::move(list), 1);
}

void PlaylistMode::begin_clip(bool) {
    went_on_s_.reset();
    shown_s_ = window_.time.script_s;
    const Playlist& list = clips_.list();
    if (list.size() > 1)
        window_.say(window_.clip->name() + ", " + std::to_string(list.place() + 1) + " of " +
                    std::to_string(list.size()));
}

void PlaylistMode::draw(PanelFacts& facts, const Seen&) {
    facts.clips = clips_.list().size();
}

// --- The measure

void MeasureMode::take(const WindowCommand& command) {
    if (command.word == "off") return let_go();
    if (command.word == "here") {
        if (!tool_.is_held()) take({WindowVerb::measure});
        tool_.hold(true);  // a line that was begun ends
        for (const auto kind : {InputEvent::Kind::pressed, InputEvent::Kind::released})
            tool_.take({.kind = kind, .word = "left"}, input_.clicked());
        return;
    }
    if (command.places.empty()) {
        tool_.hold(!tool_.is_held());
        if (!tool_.is_held()) return;
        window_.take_button(*this);
        return window_.say("measure: click two places of the surface, or drag from one to the other");
    }
    OpenedClip& clip = *window_.clip;
    const Scene& scene = clip.scene();
    for (const PixelOfFrame& place : command.places)
        if (place.x >= scene.width || place.y >= scene.height)
            return window_.say("measure: there is no pixel " + std::to_string(place.x) + ", " +
                                   std::to_string(place.y) + "; the depth has " +
                                   size_text(scene.width, scene.height),
                               Tone::refusal);
    tool_.set({command.places[0].x, command.places[0].y}, {command.places[1].x, command.places[1].y});
    const ScreenSize size = window_.screen->size();
    if (const WatchedMoment* const newest = clip.session().look())
        prepare(
            {*newest, HeightField(scene, newest->held.pair), clip.view().camera(size.width, size.height)});
}

bool MeasureMode::handle_pointer(const InputEvent& event, const glm::dvec2& at, bool is_of_panel) {
    return !is_of_panel && tool_.take(event, at);
}

bool MeasureMode::leave() {
    if (!tool_.is_held() && !tool_.has_line()) return false;
    let_go();
    return true;
}

/// Measures in the picture of this moment.
void MeasureMode::prepare(const Seen& seen) {
    const FramePair& pair = seen.moment.held.pair;
    tool_.look({.field = seen.field,
                .pair = pair,
                .camera = seen.camera,
                .stored = seen.moment.stored ? seen.moment.stored->depth : PlaneView{},
                .frame = pair.nearer().number,
                .pointer = input_.pointer_over_picture()});
    constexpr std::size_t most_told = 1000;
    for (MeasureTool::News& news : tool_.take_news()) {
        if (news.is_bad)
            window_.say(std::move(news.words), Tone::refusal);
        else if (lines_.size() < most_told)
            lines_.push_back(std::move(news.words));
    }
}

void MeasureMode::draw(PanelFacts& facts, const Seen& seen) {
    facts.measure = tool_.facts(seen.camera, window_.clip->scene());
}

// --- The brush

BrushMode::BrushMode(WindowState& window, WindowPanel& panel, WindowClips& clips, ClipPicture& surface)
    : WindowMode(window), panel_(panel), clips_(clips), surface_(surface), brush_(window.options) {}

/// Refuses commands when the clip is about to go: they are not meant for the next one.
void BrushMode::take(const WindowCommand& command) {
    if (window_.quits() || clips_.has_next())
        return window_.say("painting is off while the next clip opens", Tone::refusal);
    brush_.take(command);
    if (brush_.is_held()) {
        window_.take_button(*this);
        if (command.verb == WindowVerb::tool || command.verb == WindowVerb::material) panel_.shown = true;
    }
    take_news();
}

bool BrushMode::handle_pointer(const InputEvent& event, const glm::dvec2& at, bool is_of_panel) {
    return window_.clip && brush_.take(event, at, is_of_panel, window_.screen->size());
}

bool BrushMode::leave() {
    if (!brush_.is_held()) return false;
    take({.verb = WindowVerb::tool, .word = "touch"});
    return true;
}

void BrushMode::go_on(double) {
    brush_.go_on(window_.screen->size());
    take_news();
}

void BrushMode::prepare(const Seen&) {
    surface_.set_tint(brush_.tint());
}

void BrushMode::draw(PanelFacts& facts, const Seen& seen) {
    facts.brush = brush_.facts();
    facts.brush.work = brush_.words();
    if (!facts.place.pixel) return;
    if (const auto words = brush_.segment_words(seen.moment, facts.place.pixel->x, facts.place.pixel->y);
        !words.empty())
        facts.place.lines.insert(facts.place.lines.begin() + 1, words);
}

void BrushMode::begin_clip(bool) {
    brush_.go_to(*window_.clip);
}

/// Passes on its messages, and the materials to feel.
void BrushMode::take_news() {
    const WindowBrush::News news = brush_.take_news();
    const bool is_felt = clips_.wanted_settings().has_materials();
    for (const auto& [words, tone, is_change] : news.remarks)
        window_.say(words + (is_change && !is_felt ? "; B feels it" : ""), tone);
    if (news.has_begun) clips_.compare_with_before();
    if (news.is_another) clips_.feel_painted(brush_.felt());
}

/// An interrupted run only prints its faults, as its result is the interruption.
Result<void> BrushMode::save() {
    Result<void> saved = brush_.finish();
    if (stop_requested()) saved = {};
    for (const auto& remark : brush_.take_news().remarks)
        if (remark.tone != Tone::remark && (saved || remark.words != saved.error().message))
            warn_on_terminal(remark.words);
    return saved;
}

}  // namespace touchable
