#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

#include "engine/given_file.hpp"
#include "player/session/painted_choice.hpp"
#include "player/view/surface_pick.hpp"
#include "player/window/window_loop.hpp"

// The brush of materials: segments are read, and changed one command after the other, on a thread, while the
// clip goes on. What comes of it is felt by the road of other settings.

namespace touchable {
namespace {

constexpr double brush_is_quick_s = 0.2;  // nobody needs to be told of it
constexpr std::size_t most_for_brush = 1000;

Result<std::string> done_by(MaterialBrush& brush, const WindowCommand& command) {
    switch (command.verb) {
        case WindowVerb::paint:
            return brush.edit(MaterialBrush::Paint{command.places[0], command.word});
        case WindowVerb::join:
            return brush.edit(MaterialBrush::Join{command.places[0], command.places[1]});
        case WindowVerb::cut: {
            SegmentCut cut{.frame = command.places[0].frame};
            for (const PixelOfFrame& place : command.places) cut.stroke.push_back({place.x, place.y});
            return brush.edit(cut);
        }
        case WindowVerb::otherwise:
            return brush.edit(MaterialBrush::Otherwise{command.word});
        case WindowVerb::undo:
            return brush.undo();
        default:
            return brush.redo();
    }
}

/// What is there already may be replaced only where it is of the same kind.
Result<void> check_saved(const std::filesystem::path& file) {
    std::error_code failed;
    if (!std::filesystem::exists(file, failed) && !failed) return {};
    const auto text = read_given_file(file, file.string(), "a file of segments", largest_segment_names);
    if (!text.ok()) return text.error();
    if (parse_segment_names(*text, file.string()).ok()) return {};
    return input_error(file.string() +
                       ": is there, and says nothing of segments; materials are not saved in its place");
}

/// The frame whose segments are shown.
std::int64_t shown_frame(const WatchedMoment& moment) {
    return moment.held.pair.prev.number;
}

}  // namespace

/// Empty: there may be one.
std::string WindowLoop::why_no_brush() const {
    if (clip_->is_camera())
        return "materials are painted on clips, whose segments can be found beforehand; this is a camera";
    if (options_.record)
        return "materials that are tried are not recorded; paint and save them in a window that records "
               "nothing";
    if (kiosk_) return "a kiosk's visitors paint nothing";
    return "";
}

void WindowLoop::take_of_brush(WindowCommand command) {
    const bool puts_away = command.verb == WindowVerb::tool && (command.word == "none" || tool_.is_held());
    if (const std::string why = why_no_brush(); !why.empty() && !puts_away) return say(why, true);
    if (command.verb == WindowVerb::tool || command.verb == WindowVerb::material) {
        hold_still(false);
        if (command.verb == WindowVerb::material) tool_.set_material(command.word);
        if (command.verb == WindowVerb::material && !tool_.is_held())
            tool_.take(BrushTool::paint);
        else if (command.verb == WindowVerb::tool && command.word.empty())
            tool_.take_or_put_away();
        else if (command.verb == WindowVerb::tool)
            tool_.take(*brush_tool_of(command.word));
        if (!tool_.is_held()) return want_painted();
        panel_->shown = true;
        begin_brush();
        return want_painted();
    }
    if (for_brush_.size() == most_for_brush)
        return say("the brush is still at work on what it was asked for before", true);
    if (command.verb == WindowVerb::paint) command.word = tool_.material();
    const std::int64_t last = std::max<std::int64_t>(clip_->frames() - 1, 0),
                       now = clip_->scene().rate.frame_at(clip_->session().playback().moment.time_ns);
    for (PixelOfFrame& place : command.places)
        if (place.frame < 0) place.frame = std::clamp<std::int64_t>(now, 0, last);
    for_brush_.push_back(std::move(command));
}

/// Reads the segments, and what is kept of them.
void WindowLoop::begin_brush() {
    if (brush_ || brush_work_.is_busy()) return;
    const bool is_first = clip_->choice().file == options_.session.clip.file;
    const BrushFiles files{.clip = clip_->choice().file,
                           .segments = is_first ? options_.segments : std::nullopt,
                           .history_folder = options_.brush_history.value_or("")};
    frames_read_ = std::make_shared<std::atomic<std::int64_t>>(0);
    brush_work_.ask(
        "segments",
        [choice = clip_->choice(), files,
         read = frames_read_](const std::stop_token& given_up) -> Result<BrushWork> {
            auto segments = read_chosen_segments(
                choice, [&read](std::int64_t frame) { read->store(frame, std::memory_order_relaxed); },
                given_up);
            if (!segments.ok()) return segments.error();
            auto begun = KeptBrush::begin(std::move(*segments), files);
            if (!begun.ok()) return begun.error();
            std::string words = begun->begun_with();
            if (words.empty()) words = "each segment feels as guessed: choose a material and click one";
            return BrushWork{std::make_shared<KeptBrush>(std::move(*begun)), std::move(words), true};
        });
}

/// The oldest command, once all before it are done.
void WindowLoop::do_next_with_brush() {
    if (for_brush_.empty() || brush_work_.is_busy()) return;
    if (!brush_) return begin_brush();
    const WindowCommand& command = for_brush_.front();
    if (command.verb == WindowVerb::save_materials) {
        save_materials(command.word.empty() ? brush_->files().saved() : std::filesystem::path(command.word));
        return for_brush_.pop_front();
    }
    frames_read_.reset();
    brush_work_.ask("changing segments",
                    [brush = std::exchange(brush_, nullptr), command](const std::stop_token&) {
                        auto said = done_by(brush->brush(), command);
                        return Result<BrushWork>(BrushWork{brush, std::move(said), false});
                    });
}

/// Once a turn of the window.
void WindowLoop::go_on_brush() {
    do_with_tool();
    for (const auto& [file, written] : brush_files_.take()) {
        const bool is_history = options_.brush_history && file.parent_path() == *options_.brush_history;
        if (!written.ok() && (!is_history || file_faults_.insert(written.error().message).second))
            say(written.error().message, true);
        if (written.ok() && !is_history)
            say(options_.names.saved(clip_->choice().file.string(), file.string()));
    }
    if (auto made = brush_work_.take()) {
        if (!made->ok()) {
            say(made->error().message, true);
            for_brush_.clear();
            tool_.take(BrushTool::none);
            return want_painted();
        }
        brush_ = std::move((*made)->brush);
        painted_ = brush_->brush().painted();
        const Result<std::string>& said = (*made)->said;
        const char* const unfelt = has_materials(wanted_settings_.value_or(settings_)) ? "" : "; B feels it";
        say(said.ok() ? *said + unfelt : said.error().message, !said.ok());
        if (!(*made)->is_begun) {
            for_brush_.pop_front();
            if (said.ok()) keep_history();
        }
        brush_state_.is_there = true;
        brush_state_.segments = painted_->by_label.size();
        brush_state_.otherwise = brush_->brush().names().otherwise;
        brush_state_.can_undo = brush_->brush().done() > 0;
        brush_state_.can_redo = brush_->brush().done() < brush_->brush().edits();
        if ((*made)->is_begun) compare_with_before();
        want_painted();
    }
    do_next_with_brush();
}

/// What is to be felt: what a person painted, and all guesses as long as a tool is in hand.
void WindowLoop::want_painted() {
    WindowSettings wanted = wanted_settings_.value_or(settings_);
    if (brush_) wanted.painted = tool_.is_held() || brush_->is_painted() ? painted_ : nullptr;
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

HeldBrush::Place WindowLoop::place_at(const glm::dvec2& at, const WatchedMoment& moment) const {
    const ScreenSize size = screen_->size();
    const HeightField field(clip_->scene(), moment.held.pair);
    const auto met = pick(field, clip_->view().camera(size.width, size.height), at.x, at.y);
    if (!met || !met->drawn) return {at};
    return {at, PixelOfFrame{static_cast<int>(std::lround(met->x)), static_cast<int>(std::lround(met->y)),
                             shown_frame(moment)}};
}

/// Whether the tool in hand has it, and not the finger.
bool WindowLoop::take_with_tool(const InputEvent& event, bool is_of_panel) {
    using Kind = InputEvent::Kind;
    const bool is_left = event.word == "left";
    const bool presses =
        event.kind == Kind::pressed && tool_.is_held() && is_left && !event.control && !is_of_panel;
    const bool releases = event.kind == Kind::released && tool_is_pressed_ && is_left;
    const bool moves = event.kind == Kind::moved && tool_.is_held() && !is_of_panel;
    if (presses || releases) tool_is_pressed_ = presses;
    if (event.kind == Kind::left_window) tool_is_pressed_ = false;
    if (presses || releases || event.kind == Kind::left_window ||
        (moves && for_tool_.size() < most_for_brush))
        for_tool_.push_back({event.kind, pointer_at_});
    do_with_tool();
    return presses || releases;
}

/// A session that has just begun shows nothing yet: what was clicked is seen once it does.
void WindowLoop::do_with_tool() {
    using Kind = InputEvent::Kind;
    if (for_tool_.empty()) return;
    const WatchedMoment* const moment = clip_->session().look();
    if (!moment) return;
    for (const auto& [kind, at] : std::exchange(for_tool_, {})) {
        const bool was_drawn = tool_.is_drawing();
        std::optional<WindowCommand> asked;
        const HeldBrush::Place place = place_at(at, *moment);
        if (kind == Kind::pressed) asked = tool_.press(place);
        if (kind == Kind::moved) tool_.move(place);
        if (kind == Kind::released) asked = tool_.release();
        if (kind == Kind::left_window && was_drawn) tool_.let_go();
        if (kind == Kind::pressed && !place.pixel && !tool_.is_drawing()) say("there is no surface here");
        if (kind == Kind::released && was_drawn && !asked) say("a cut is a stroke: drag it across a segment");
        if (asked) take(*asked);
        hold_still(tool_.is_drawing());
    }
}

/// While a stroke is drawn a clip that plays waits.
void WindowLoop::hold_still(bool still) {
    if (still == tool_holds_clip_) return;
    const PlaybackState now = clip_->session().playback();
    if (still && (!now.playing || now.at_end)) return;
    tool_holds_clip_ = still;
    say(clip_->session().ask(still ? PlaybackVerb::pause : PlaybackVerb::play));
}

void WindowLoop::keep_history() {
    if (const auto file = brush_->files().history(); !file.empty())
        brush_files_.write(file, brush_->history());
}

void WindowLoop::save_materials(const std::filesystem::path& file) {
    std::string text = brush_->save();
    keep_history();  // first: it says what was saved
    brush_files_.write(file, std::move(text), check_saved);
}

/// Of a clip that goes: what it was asked for is done. Segments that are still read are given up.
void WindowLoop::finish_brush() {
    if (!painted_) for_brush_.clear();
    while (!for_brush_.empty()) {
        go_on_brush();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    brush_work_.give_up();
}

void WindowLoop::forget_brush() {
    brush_work_.give_up();
    brush_.reset();
    painted_.reset();
    for_brush_.clear();
    brush_state_ = {};
    tool_.take(BrushTool::none);
    for_tool_.clear();
    tool_is_pressed_ = tool_holds_clip_ = false;
    if (wanted_settings_) wanted_settings_->painted.reset();
    const bool is_first = clip_->choice().file == options_.session.clip.file;
    if (options_.segments && is_first) begin_brush();
}

/// What it is at, where that takes long.
std::string WindowLoop::words_of_brush() const {
    if (!brush_work_.is_busy() || brush_work_.seconds() < brush_is_quick_s) return "";
    if (!frames_read_) return brush_work_.words() + " ...";
    const std::int64_t frames = clip_->frames(), frame = frames_read_->load(std::memory_order_relaxed);
    return "segments: frame " + std::to_string(frame) + (frames > 0 ? " of " + std::to_string(frames) : "");
}

BrushFacts WindowLoop::brush_facts() const {
    BrushFacts facts = brush_state_;
    facts.tool = tool_.tool();
    facts.material = tool_.material();
    facts.materials_are_on = clip_->in_effect().at("materials") == "on";
    facts.line.assign(tool_.line().begin(), tool_.line().end());
    return facts;
}

/// The segment at a pixel of the depth plane, and what it is; empty where none is shown or felt.
std::string WindowLoop::segment_words(const WatchedMoment& moment, int x, int y) const {
    const bool is_of_interest = painted_ && (tool_.is_held() || clip_->in_effect().at("materials") == "on");
    if (!is_of_interest || shown_frame(moment) >= painted_->segments->frames()) return "";
    const std::uint16_t label = painted_->segments->label_at(shown_frame(moment), x, y);
    const auto paint = painted_->by_label.find(label);
    if (paint == painted_->by_label.end()) return "no segment";
    const auto& [name, material, feel, is_guess] = paint->second;
    const std::string number = "segment " + std::to_string(label);
    return number + (name.empty() || name == number ? "" : ", " + name) + ": " +
           (material.empty() ? "values of its own" : material) + (is_guess ? " (guess)" : "");
}

}  // namespace touchable
