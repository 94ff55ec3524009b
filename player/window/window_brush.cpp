// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_brush.hpp"

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr double brush_is_quick_s = 0.2;  // shorter work is not mentioned
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
        case WindowVerb::redo:
            return brush.redo();
        default:
            return internal_error("the brush was asked for what it does not do");
    }
}

/// Allows replacing only a file of segments.
Result<void> check_saved(const std::filesystem::path& file) {
    std::error_code failed;
    if (!std::filesystem::exists(file, failed) && !failed) return {};
    TRY_ASSIGN(const auto text,
               read_given_file(file, file.string(), "a file of segments", largest_segment_names));
    if (parse_segment_names(text, file.string())) return {};
    return input_error(file.string() +
                       ": is there, and says nothing of segments; materials are not saved in its place");
}

/// The frame whose segments are shown.
std::int64_t shown_frame(const WatchedMoment& moment) {
    return moment.held.pair.prev.number;
}

}  // namespace

/// Why painting is not possible; empty: it is.
std::string WindowBrush::why_none() const {
    if (clip_->is_camera()) return "a camera has no brush: segments are found in a whole clip";
    if (options_.record)
        return "a window that records has no brush; paint and save materials in one that does not";
    if (options_.kiosk) return "a kiosk has no brush";
    return "";
}

void WindowBrush::take(WindowCommand command) {
    const bool puts_away =
        command.verb == WindowVerb::tool &&
        (command.word.empty() ? is_held() : brush_tool_of(command.word) == BrushTool::touch);
    if (const std::string why = why_none(); !why.empty() && !puts_away) return refuse(command, why);
    if (command.verb == WindowVerb::tool || command.verb == WindowVerb::material) return take_tool(command);
    if (asked_.size() == most_for_brush)
        return refuse(command, "the brush is busy with the command before; try again in a moment");
    if (command.verb == WindowVerb::paint) command.word = tool_.material();
    const std::int64_t frames = painted_ ? painted_->segments->frames() : clip_->frames(),
                       last = frames > 0 ? frames - 1 : std::numeric_limits<std::int64_t>::max(),
                       now = clip_->scene().rate.frame_at(clip_->session().playback().moment.time_ns);
    for (PixelOfFrame& place : command.places)
        if (place.frame < 0) place.frame = std::clamp<std::int64_t>(now, 0, last);
    asked_.push_back(std::move(command));
}

void WindowBrush::take_tool(const WindowCommand& command) {
    hold_still(false);
    news_.is_another = true;
    if (command.verb == WindowVerb::material) {
        tool_.set_material(command.word);
        tool_.take(BrushTool::paint);
    } else if (command.word.empty()) {
        tool_.take_or_put_away();
    } else {
        tool_.take(*brush_tool_of(command.word));
    }
    if (is_held()) begin();
}

/// Reads the segments and their saved materials.
void WindowBrush::begin() {
    if (brush_ || work_.is_busy()) return;
    const ClipChoice& choice = clip_->choice();
    const BrushFiles files{.clip = choice.file,
                           .segments = is_first_clip() ? options_.segments : std::nullopt,
                           .history_folder = options_.brush_history.value_or(""),
                           .opened_as = segments_depend_on(choice)};
    frames_read_ = std::make_shared<std::atomic<std::int64_t>>(0);
    work_.ask("segments",
              [choice, files, read = frames_read_,
               is_history_late = files_.waits_for(files.history())]() -> Result<Work> {
                  TRY_ASSIGN(auto segments, read_chosen_segments(choice, [&read](std::int64_t frame) {
                                 read->store(frame, std::memory_order_relaxed);
                             }));
                  // If the clip was left just now, its history is read after it is written.
                  (void)wait_unless_stopped([&] { return !is_history_late(); }, std::chrono::milliseconds(5));
                  TRY_ASSIGN(auto begun, KeptBrush::begin(std::move(segments), files));
                  std::string words = begun.begun_with();
                  if (words.empty()) words = "each segment feels as guessed: choose a material and click one";
                  return Work{std::make_shared<KeptBrush>(std::move(begun)), std::move(words)};
              });
}

/// Runs the oldest command, once the earlier ones are done.
void WindowBrush::do_next() {
    if (asked_.empty() || work_.is_busy()) return;
    if (!brush_) return begin();
    const WindowCommand& command = asked_.front();
    if (command.verb == WindowVerb::save_materials) {
        save(command.word.empty() ? brush_->files().saved() : std::filesystem::path(command.word));
        return asked_.pop_front();
    }
    frames_read_.reset();
    work_.ask("changing segments", [brush = brush_, command]() -> Result<Work> {
        Work done{brush, done_by(brush->brush(), command)};
        if (done.said) done.history = brush->history();
        return done;
    });
}

/// Takes the thread's result, if it is done.
void WindowBrush::take_made() {
    const auto made = work_.take();
    if (!made) return;
    news_.is_another = true;
    if (!brush_ && !*made) return refuse_all(made->error());
    const bool has_begun = !brush_;
    if (has_begun) brush_ = (*made)->brush;
    note_state();
    const Result<std::string> said = *made ? (*made)->said : made->error();
    if (said)
        news_.remarks.push_back({*said, Tone::remark, true});
    else if (said.error().kind != ErrorKind::interrupted)
        say(said.error().message, said.error().kind == ErrorKind::usage ? Tone::refusal : Tone::fault);
    if (has_begun)
        news_.has_begun = true;
    else
        asked_.pop_front();
    if (said && !has_begun) keep_history((*made)->history);
}

/// There are no segments.
void WindowBrush::refuse_all(const Error& why) {
    if (why.kind != ErrorKind::interrupted) {
        say(why.message, Tone::fault);
        if (options_.segments && is_first_clip()) segments_fault_ = why;
    }
    drop_asked(why);
    tool_.take(BrushTool::touch);
}

/// Drops commands that can no longer run. Returns whether a save was among them.
bool WindowBrush::drop_asked(const Error& why) {
    const bool is_unsaved = std::ranges::any_of(
        asked_, [](const WindowCommand& command) { return command.verb == WindowVerb::save_materials; });
    if (is_unsaved) save_fault_ = why;
    asked_.clear();
    return is_unsaved;
}

void WindowBrush::note_state() {
    painted_ = brush_->brush().painted();
    is_painted_ = brush_->is_painted();
    state_.is_there = true;
    state_.segments = painted_->by_label.size();
    state_.otherwise = brush_->brush().names().otherwise;
    state_.can_undo = brush_->brush().done() > 0;
    state_.can_redo = brush_->brush().done() < brush_->brush().edits();
}

void WindowBrush::go_on(const ScreenSize& size) {
    do_with_tool(size);
    note_files();
    take_made();
    do_next();
}

/// Reports a history's fault once.
void WindowBrush::note_files() {
    while (options_.is_offline() && !stop_requested() && !files_.wait(std::chrono::milliseconds(50))) {
    }
    for (const auto& [file, clip, written] : files_.take()) {
        const bool is_saved = !clip.empty();
        if (is_saved)
            save_fault_ = written ? std::nullopt : std::optional(written.error());
        else if (!written)
            lost_history_ = file;
        else if (file == lost_history_)
            lost_history_.clear();
        if (!written && (is_saved || faults_.insert(written.error().message).second))
            say(written.error().message, Tone::fault);
        if (written && is_saved) say(options_.names.saved(clip, file.string()));
    }
}

HeldBrush::Place WindowBrush::place_at(const glm::dvec2& at, const WatchedMoment& moment,
                                       const ScreenSize& size) const {
    const HeightField field(clip_->scene(), moment.held.pair);
    const auto met = pick(field, clip_->view().camera(size.width, size.height), at.x, at.y);
    if (!met || !met->drawn) return {at};
    return {at, PixelOfFrame{met->pixel().x, met->pixel().y, shown_frame(moment)}};
}

bool WindowBrush::take(const InputEvent& event, const glm::dvec2& pointer, bool is_of_panel,
                       const ScreenSize& size) {
    using Kind = InputEvent::Kind;
    const bool is_left = event.word == "left";
    const bool presses =
        event.kind == Kind::pressed && is_held() && is_left && !event.control && !is_of_panel;
    const bool releases = event.kind == Kind::released && is_pressed_ && is_left;
    const bool moves = event.kind == Kind::moved && is_held() && !is_of_panel;
    if (presses || releases) is_pressed_ = presses;
    if (event.kind == Kind::left_window) is_pressed_ = false;
    if (presses || releases || event.kind == Kind::left_window ||
        (moves && for_tool_.size() < most_for_brush))
        for_tool_.push_back({event.kind, pointer});
    do_with_tool(size);
    return presses || releases;
}

/// Clicks wait until a new session shows its first picture; those for an ended session are dropped.
void WindowBrush::do_with_tool(const ScreenSize& size) {
    using Kind = InputEvent::Kind;
    if (for_tool_.empty()) return;
    const WatchedMoment* const moment = clip_->session().look();
    if (!moment && !clip_->session().running()) for_tool_.clear();
    if (!moment) return;
    for (const auto& [kind, at] : std::exchange(for_tool_, {})) {
        const bool was_drawn = tool_.is_drawing();
        std::optional<WindowCommand> asked;
        const HeldBrush::Place place = place_at(at, *moment, size);
        if (kind == Kind::pressed) asked = tool_.press(place);
        if (kind == Kind::moved) tool_.move(place);
        if (kind == Kind::released) asked = tool_.release();
        if (kind == Kind::left_window && was_drawn) tool_.let_go();
        if (kind == Kind::pressed && !place.pixel && !tool_.is_drawing()) say("there is no surface here");
        if (kind == Kind::released && was_drawn && !asked) say("a cut is a stroke: drag it across a segment");
        if (kind == Kind::pressed && tool_.has_first()) say("now click the segment to join with it");
        if (asked) take(std::move(*asked));
        hold_still(tool_.is_drawing());
    }
}

/// Pauses a playing clip while a stroke is drawn.
void WindowBrush::hold_still(bool still) {
    if (still == holds_clip_) return;
    const PlaybackState now = clip_->session().playback();
    if (still && (!now.playing || now.at_end)) return;
    holds_clip_ = still;
    if (auto asked = clip_->session().ask(still ? PlaybackVerb::pause : PlaybackVerb::play); !asked)
        say(asked.error().message, Tone::refusal);
}

void WindowBrush::save(const std::filesystem::path& file) {
    std::string text = brush_->save();
    keep_history(brush_->history());  // first, as it records the saved state
    files_.give(text_file(file, std::move(text), brush_->files().clip.string(), check_saved));
}

void WindowBrush::go_to(OpenedClip& clip) {
    clip_ = &clip;
    work_.let_go();
    brush_.reset();
    painted_.reset();
    is_painted_ = is_pressed_ = holds_clip_ = false;
    if (const Error why = usage_error("materials are not saved: another clip came first"); drop_asked(why))
        say(why.message, Tone::fault);
    for_tool_.clear();
    state_ = {};
    tool_.take(BrushTool::touch);
    if (options_.segments && is_first_clip()) begin();
}

Result<void> WindowBrush::finish() {
    work_.give_up();
    if (const Error why = usage_error("materials are not saved: the window closed first"); drop_asked(why))
        say(why.message, Tone::fault);
    files_.finish();
    note_files();
    if (segments_fault_) return *segments_fault_;
    if (save_fault_) return *save_fault_;
    return {};
}

std::string WindowBrush::unsaved_words() const {
    if (!brush_ || !is_painted_ || brush_->is_saved()) return "";
    const std::filesystem::path& history = brush_->history_file();
    const std::string words = "what was painted is not saved";
    if (history.empty()) return words + ", and is lost";
    return words + (history == lost_history_ ? "; not all of it is in " : "; it is in ") + history.string() +
           " for the next window";
}

std::string WindowBrush::words() const {
    if (!work_.is_busy() || work_.seconds() < brush_is_quick_s) return "";
    if (!frames_read_) return work_.words() + " ...";
    const std::int64_t frames = clip_->frames(), frame = frames_read_->load(std::memory_order_relaxed);
    return "finding segments: " + std::to_string(frame) +
           (frames > 0 ? " of " + std::to_string(frames) : std::string()) + " frames";
}

BrushFacts WindowBrush::facts() const {
    BrushFacts facts = state_;
    facts.tool = tool_.tool();
    facts.material = tool_.material();
    facts.materials_are_on = clip_->in_effect().at("materials") == "on";
    facts.line.assign(tool_.line().begin(), tool_.line().end());
    return facts;
}

std::string WindowBrush::segment_name(const WatchedMoment& moment, const glm::dvec2& pixel) const {
    if (!painted_ || shown_frame(moment) >= painted_->segments->frames()) return "";
    const SegmentStore& segments = *painted_->segments;
    const auto place = [](double at, int side) {
        return std::clamp(static_cast<int>(std::lround(at)), 0, side - 1);
    };
    const auto paint = painted_->by_label.find(segments.label_at(
        shown_frame(moment), place(pixel.x, segments.width()), place(pixel.y, segments.height())));
    return paint == painted_->by_label.end() ? "" : paint->second.name;
}

std::string WindowBrush::segment_words(const WatchedMoment& moment, int x, int y) const {
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
