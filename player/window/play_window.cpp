#include "player/window/play_window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "player/session/interrupt.hpp"
#include "player/view/surface_pick.hpp"
#include "player/window/canvas.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/kept_settings.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/pointer_input.hpp"
#include "player/window/what_is_seen.hpp"
#include "player/window/window_panel.hpp"
#include "player/window/window_sound.hpp"

namespace touchable {
namespace {

using Clock = std::chrono::steady_clock;

// From the begin of one picture to the next, at least: as often as screens show one, but where drawing takes
// so long that decoding would suffer.
constexpr double picture_pause_ms = 16, slowest_pause_ms = 50, share_of_drawing = 0.75;
constexpr double idle_pause_ms = 200;   // and at most, so that clock and figures go on
constexpr double after_input_ms = 300;  // buttons fade
constexpr double message_s = 4;
constexpr const char* first_words =
    "move over the picture, and hold the left button to touch it; ? shows all keys";

double seconds_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

/// Of a picture that nobody gave a name.
std::filesystem::path free_name() {
    for (int number = 1;; ++number) {
        std::filesystem::path file = "touchable-" + std::to_string(number) + ".png";
        std::error_code ignored;
        if (!std::filesystem::exists(file, ignored)) return file;
    }
}

class PlayWindow {
public:
    explicit PlayWindow(const PlayOptions& options) : options_(options) {}

    Result<void> open();
    Result<PlayFigures> run();

private:
    void take_script();
    void take(const InputEvent& event);
    void take(const WindowCommand& command);
    void ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0);
    void seek(double seconds);
    void go_on_seeking(const WatchedMoment* moment);
    void step(double frames);
    void toggle_loop();
    Result<std::unique_ptr<OpenedClip>> open_clip(const ClipChoice& choice);
    void open_other(const std::string& file);
    Result<void> keep_picture(const std::filesystem::path& name);
    void feel(const WindowCommand& command);
    void feel(const TwoSettings& wanted);
    void go_on_feeling();
    void reset();
    KeptSettings to_keep() const;
    void say(std::string words, bool bad = false);
    void sum_up();
    double pause_ms() const;
    bool is_due(const WatchedMoment* moment, Clock::time_point now) const;
    Result<void> draw(const WatchedMoment& moment);
    double now_s() const { return seconds_between(begun_, Clock::now()); }

    const PlayOptions& options_;
    std::unique_ptr<Screen> screen_;
    std::shared_ptr<GpuDevice> device_;
    std::optional<ClipPicture> picture_;
    std::unique_ptr<ImGuiLayer> layer_;
    std::optional<WindowPanel> panel_;
    std::unique_ptr<WindowSound> sound_;
    std::unique_ptr<OpenedClip> clip_;
    SettingsFile settings_;
    TwoSettings felt_;
    std::optional<TwoSettings> wanted_felt_;  // to be changed to
    std::int64_t changed_at_ = 0;             // figures_.pictures at the last change
    PointerInput pointer_;
    std::vector<InputEvent> events_;  // since the last picture
    std::vector<WindowCommand> asked_;
    std::size_t scripted_ = 0;
    Clock::time_point begun_, last_picture_, last_event_, message_at_;
    std::optional<Clock::time_point> first_event_;  // not in a picture yet
    WhatIsSeen seen_;
    std::optional<std::int64_t> wanted_ns_;  // of the clip, to be gone to
    std::string message_;
    bool message_is_bad_ = false, quit_ = false, fullscreen_ = false;
    double last_draw_ms_ = 0;
    PlayFigures figures_;
};

Result<void> PlayWindow::open() {
    if (options_.settings_file) settings_ = SettingsFile(*options_.settings_file);
    const KeptSettings& kept = settings_.read();
    if (!options_.filters_are_stated) felt_ = {kept.a, kept.b};
    if (!settings_.message().empty()) say(settings_.message(), true);
    ScreenOptions as_kept = options_.screen;
    if (!options_.size_is_stated && kept.width > 0) {
        as_kept.width = kept.width;
        as_kept.height = kept.height;
    }
    if (options_.headless) {
        screen_ = make_headless_screen(as_kept);
    } else {
        auto screen = open_glfw_screen(as_kept);
        if (!screen.ok()) return screen.error();
        screen_ = std::move(*screen);
    }
    auto device = GpuDevice::open(
        {.request = options_.session.builder.gpu, .window_extensions = screen_->extensions()});
    if (!device.ok()) return device.error();
    device_ = std::move(*device);
    if (auto attached = screen_->attach(device_); !attached.ok()) return attached;
    auto picture = ClipPicture::create(device_, options_.painter);
    if (!picture.ok()) return picture.error();
    picture_.emplace(std::move(*picture));
    const double scale = screen_->size().scale;
    auto layer = ImGuiLayer::create(device_, scale);
    if (!layer.ok()) return layer.error();
    layer_ = std::move(*layer);
    panel_.emplace(scale);
    auto sound = WindowSound::create(!options_.headless, options_.sound, options_.existing);
    if (!sound.ok()) return sound.error();
    sound_ = std::move(*sound);
    panel_->shown = kept.panel;
    auto clip = open_clip(options_.session.clip);
    if (!clip.ok()) return clip.error();
    clip_ = std::move(*clip);
    clip_->fingers().set_count(kept.fingers);
    if (const auto overlay = overlay_after(Overlay::colour, kept.overlay); overlay.ok())
        picture_->set_overlay(*overlay);
    clip_->begin_sound();
    screen_->set_title(clip_->name() + " - touchable");
    fullscreen_ = options_.screen.fullscreen;
    return {};
}

Result<PlayFigures> PlayWindow::run() {
    begun_ = last_picture_ = Clock::now();
    while (!quit_ && !interrupted()) {
        const WatchedMoment* const moment = clip_->session().look();
        const auto now = Clock::now();
        go_on_seeking(moment);
        if (is_due(moment, now)) {
            if (auto drawn = draw(*moment); !drawn.ok()) return drawn.error();
        }
        const double left_ms = pause_ms() - 1000 * seconds_between(last_picture_, Clock::now());
        const auto wait = std::chrono::milliseconds(std::clamp(static_cast<int>(left_ms), 1, 8));
        for (const InputEvent& event : screen_->poll(wait)) take(event);
        take_script();
        for (const WindowCommand& command : std::exchange(asked_, {})) take(command);
        go_on_feeling();
        if (!clip_->session().running() && message_.empty())
            if (const auto failure = clip_->session().failure()) say(failure->message, true);
        if (options_.seconds && now_s() >= *options_.seconds) quit_ = true;
    }
    Result<void> kept;
    if (options_.screenshot && !interrupted()) kept = keep_picture(*options_.screenshot);
    sum_up();
    if (auto written = settings_.write(to_keep()); !written.ok()) figures_.not_kept = written.error().message;
    if (auto finished = clip_->finish(); !finished.ok()) return finished.error();
    if (auto finished = sound_->finish(); !finished.ok()) return finished.error();
    if (const auto failure = clip_->session().failure()) return *failure;
    if (!kept.ok()) return kept.error();
    if (interrupted())
        return Error{ErrorKind::interrupted, "interrupted; what was asked for is written, up to there"};
    return std::move(figures_);
}

void PlayWindow::sum_up() {
    const WatchedFigures session = clip_->session().figures();
    figures_.seconds = now_s();
    figures_.painter = picture_->painter();
    figures_.gpu = device_->facts().name;
    figures_.builder = session.feed.builder;
    figures_.ticks = session.ticks.ticks;
    figures_.late_ticks = session.ticks.late;
    figures_.frames = session.feed.frames;
    figures_.late_frames = session.late_frames;
    figures_.dropped_frames = session.feed.dropped;
}

/// Nothing is drawn again where nothing has moved.
bool PlayWindow::is_due(const WatchedMoment* moment, Clock::time_point now) const {
    const double since_ms = 1000 * seconds_between(last_picture_, now);
    if (!moment || since_ms < pause_ms()) return false;
    const bool has_input = !events_.empty() || 1000 * seconds_between(last_event_, now) < after_input_ms;
    return has_input || since_ms >= idle_pause_ms ||
           seen_.differs(*moment, clip_->fingers().shown(), clip_->sizes().finger_radius / 50);
}

double PlayWindow::pause_ms() const {
    return std::clamp(last_draw_ms_ / share_of_drawing, picture_pause_ms, slowest_pause_ms);
}

void PlayWindow::take_script() {
    while (scripted_ < options_.script.size() && options_.script[scripted_].seconds <= now_s()) {
        const auto& what = options_.script[scripted_++].what;
        if (const auto* event = std::get_if<InputEvent>(&what))
            take(*event);
        else
            take(std::get<WindowCommand>(what));
    }
}

void PlayWindow::take(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    last_event_ = Clock::now();
    if (!first_event_) first_event_ = last_event_;
    events_.push_back(event);
    if (event.kind == Kind::close) quit_ = true;
    if (event.kind == Kind::dropped) open_other(event.word);
    if (event.kind == Kind::key && !layer_->takes_keys()) {
        for (const KeyBinding& binding : key_bindings())
            if (event.word == binding.key && event.shift == binding.shift)
                return take(WindowCommand{binding.verb, binding.number, ""});
        return;
    }
    const bool is_of_panel = layer_->takes_pointer();
    if (is_of_panel && event.kind == Kind::moved) pointer_.leave(clip_->fingers());
    if (is_of_panel && event.kind != Kind::released) return;
    const ScreenSize size = screen_->size();
    pointer_.take(event, clip_->fingers(), clip_->view(), size.width, size.height);
    screen_->hide_pointer(clip_->fingers().pointer().has_value());
}

void PlayWindow::ask(PlaybackVerb verb, std::int64_t first, std::int64_t second) {
    if (auto asked = clip_->session().ask(verb, first, second); !asked.ok()) say(asked.error().message, true);
}

void PlayWindow::seek(double seconds) {
    const double frame = static_cast<double>(clip_->scene().rate.time_ns(1)) * 1e-9;
    wanted_ns_ =
        static_cast<std::int64_t>(std::clamp(seconds, 0.0, std::max(0.0, clip_->seconds() - frame)) * 1e9);
}

/// One after the other: whoever drags the seek bar sees every place that there is time for, and in the end
/// the last.
void PlayWindow::go_on_seeking(const WatchedMoment* moment) {
    if (!wanted_ns_ || !moment || moment->held.pair.epoch != clip_->session().playback().moment.epoch) return;
    ask(PlaybackVerb::seek, *std::exchange(wanted_ns_, std::nullopt));
}

void PlayWindow::step(double frames) {
    if (frames > 0) return ask(PlaybackVerb::step);
    const FrameRate& rate = clip_->scene().rate;
    const std::int64_t now = rate.frame_at(clip_->session().playback().moment.time_ns);
    ask(PlaybackVerb::pause);
    wanted_ns_ = rate.time_ns(std::max<std::int64_t>(0, now - 1));
}

void PlayWindow::toggle_loop() {
    if (clip_->session().playback().loops) return ask(PlaybackVerb::unloop);
    ask(PlaybackVerb::loop, 0, static_cast<std::int64_t>(clip_->seconds() * 1e9));
}

void PlayWindow::take(const WindowCommand& command) {
    const PlaybackState state = clip_->session().playback();
    const double seconds = static_cast<double>(wanted_ns_.value_or(state.moment.time_ns)) * 1e-9;
    const double speed = static_cast<double>(state.rate) / 1000;
    PointerFingers& fingers = clip_->fingers();
    const ScreenSize size = screen_->size();
    switch (command.verb) {
        case WindowVerb::play_pause:
            if (state.at_end) {
                seek(0);
                return ask(PlaybackVerb::play);
            }
            return ask(state.playing ? PlaybackVerb::pause : PlaybackVerb::play);
        case WindowVerb::seek_by:
            return seek(seconds + command.number);
        case WindowVerb::seek_to:
            return seek(command.number);
        case WindowVerb::step:
            return step(command.number);
        case WindowVerb::faster:
        case WindowVerb::speed: {
            const double wanted = command.verb == WindowVerb::speed ? command.number : speed * command.number;
            return ask(PlaybackVerb::rate, std::lround(std::clamp(wanted, 0.1, 4.0) * 1000));
        }
        case WindowVerb::loop:
            return toggle_loop();
        case WindowVerb::fingers:
            return fingers.set_count(static_cast<int>(command.number));
        case WindowVerb::deeper:
            return fingers.deepen(command.number / 1000);
        case WindowVerb::point_right:
            return pointer_.move_by({command.number, 0}, size.width, size.height, fingers);
        case WindowVerb::point_down:
            return pointer_.move_by({0, command.number}, size.width, size.height, fingers);
        case WindowVerb::force:
            clip_->device().set_force(!clip_->device().force_is_on());
            return say(clip_->device().force_is_on() ? "force on" : "force off");
        case WindowVerb::mute:
            sound_->set_muted(!sound_->is_muted());
            return say(sound_->state());
        case WindowVerb::overlay: {
            const auto overlay = overlay_after(picture_->overlay(), command.word);
            if (!overlay.ok()) return say(overlay.error().message, true);
            return picture_->set_overlay(*overlay);
        }
        case WindowVerb::home:
            return clip_->view().go_home();
        case WindowVerb::turn:
            return clip_->view().turn(command.number, 0);
        case WindowVerb::tilt:
            return clip_->view().turn(0, command.number);
        case WindowVerb::nearer:
            return clip_->view().near_by(command.number);
        case WindowVerb::panel:
            panel_->shown = !panel_->shown;
            return;
        case WindowVerb::help:
            panel_->help_shown = !panel_->help_shown;
            return;
        case WindowVerb::fullscreen:
            fullscreen_ = !fullscreen_;
            return screen_->set_fullscreen(fullscreen_);
        case WindowVerb::size:
            return screen_->set_size(command.width, command.height);
        case WindowVerb::screenshot:
            if (auto kept = keep_picture(command.word); !kept.ok()) say(kept.error().message, true);
            return;
        case WindowVerb::open:
            return open_other(command.word);
        case WindowVerb::feel:
        case WindowVerb::settings:
            return feel(command);
        case WindowVerb::reset:
            return reset();
        case WindowVerb::quit:
            quit_ = true;
            return;
    }
}

/// Settings that do not go with the clip are not in effect then; they stay for the next one.
Result<std::unique_ptr<OpenedClip>> PlayWindow::open_clip(const ClipChoice& choice) {
    auto opened = OpenedClip::open(options_, choice, felt_.now(), *sound_);
    if (opened.ok() || felt_.now() == FeltSettings{}) return opened;
    auto plain = OpenedClip::open(options_, choice, {}, *sound_);
    if (plain.ok()) say("felt as the clip says: " + opened.error().message, true);
    return plain;
}

void PlayWindow::feel(const WindowCommand& command) {
    TwoSettings wanted = wanted_felt_.value_or(felt_);
    const std::size_t space = command.word.find(' ');
    if (command.verb == WindowVerb::settings) {
        wanted.turn_to(command.word.empty() ? !wanted.b_is_on : command.word == "b");
    } else if (auto set = wanted.set(command.word.substr(0, space), command.word.substr(space + 1));
               !set.ok()) {
        return say(set.error().message, true);
    }
    feel(wanted);
}

void PlayWindow::feel(const TwoSettings& wanted) {
    if (options_.record)
        return say("a recording is of one set of settings; change them without --record", true);
    wanted_felt_ = wanted;
}

/// One after the other: whoever holds a key sees and feels each that there is time for, and in the end the
/// last.
void PlayWindow::go_on_feeling() {
    const bool was_seen = figures_.pictures > changed_at_ || !clip_->session().running();
    if (!wanted_felt_ || !was_seen) return;
    const TwoSettings wanted = *std::exchange(wanted_felt_, std::nullopt);
    if (auto changed = clip_->change(wanted.now()); !changed.ok()) return say(changed.error().message, true);
    felt_ = wanted;
    changed_at_ = figures_.pictures;
    picture_->forget();
    say(felt_.in_words());
}

void PlayWindow::reset() {
    feel(TwoSettings());
    panel_->shown = false;
    clip_->fingers().set_count(KeptSettings().fingers);
    picture_->set_overlay(Overlay::colour);
    if (!fullscreen_) screen_->set_size(options_.screen.width, options_.screen.height);
}

KeptSettings PlayWindow::to_keep() const {
    KeptSettings kept = settings_.read();
    kept.panel = panel_->shown;
    kept.fingers = clip_->fingers().count();
    kept.overlay = name_of(picture_->overlay());
    if (!options_.filters_are_stated) {
        const TwoSettings felt = wanted_felt_.value_or(felt_);
        kept.a = felt.a;
        kept.b = felt.b;
    }
    const ScreenSize size = screen_->size();
    if (options_.size_is_stated || fullscreen_ || size.width < 1) return kept;
    kept.width = static_cast<int>(std::lround(size.width / size.scale));
    kept.height = static_cast<int>(std::lround(size.height / size.scale));
    return kept;
}

/// The clip that is there goes on where the other one cannot be opened.
void PlayWindow::open_other(const std::string& file) {
    ClipChoice choice;
    choice.file = file;
    if (options_.record) return say("a recording is of one clip; open another without --record", true);
    auto opened = open_clip(choice);
    if (!opened.ok()) return say(opened.error().message, true);
    if (auto finished = clip_->finish(); !finished.ok()) say(finished.error().message, true);
    (*opened)->fingers().set_count(clip_->fingers().count());
    clip_ = std::move(*opened);
    clip_->begin_sound();
    picture_->forget();
    wanted_ns_.reset();
    pointer_ = PointerInput();
    screen_->set_title(clip_->name() + " - touchable");
}

Result<void> PlayWindow::keep_picture(const std::filesystem::path& name) {
    if (figures_.pictures == 0) return usage_error("there is no picture yet that could be kept");
    const auto image = read_back(device_, picture_->canvas());
    if (!image.ok()) return image.error();
    const std::filesystem::path file = name.empty() ? free_name() : name;
    NewFile out(file, options_.existing);
    if (auto usable = out.check(); !usable.ok()) return usable;
    if (auto written = write_png(out, image->view()); !written.ok()) return written;
    if (auto done = out.commit(); !done.ok()) return done;
    say("kept as " + file.string());
    return {};
}

void PlayWindow::say(std::string words, bool bad) {
    message_ = std::move(words);
    message_is_bad_ = bad;
    message_at_ = Clock::now();
}

Result<void> PlayWindow::draw(const WatchedMoment& moment) {
    const ScreenSize size = screen_->size();
    const auto begin = Clock::now();
    const double since = seconds_between(last_picture_, begin);
    last_picture_ = begin;
    seen_.remember(moment, clip_->fingers().shown());
    if (size.width < 1 || size.height < 1) {  // minimised
        events_.clear();
        return {};
    }
    if (!message_.empty() && seconds_between(message_at_, begin) > message_s) message_.clear();

    const HeightField field(clip_->scene(), moment.held.pair);
    const ViewCamera camera = clip_->view().camera(size.width, size.height);
    if (const auto at = pointer_.take_double_click())
        if (const auto met = pick(field, camera, at->x, at->y)) clip_->view().look_at(met->point);
    clip_->fingers().intend(field, camera);

    auto commands = GpuCommands::begin(device_, "window");
    if (!commands.ok()) return commands.error();
    const auto marks = clip_->trails().marks(moment.felt, clip_->fingers().shown(), field);
    auto drawn = picture_->draw(*commands, moment, field, camera, marks, clip_->sizes());
    if (!drawn.ok()) return drawn;
    PanelFacts facts = panel_facts(*clip_, *picture_, moment, field, camera);
    facts.felt.b_is_on = felt_.b_is_on;
    facts.felt.is_fixed = options_.record.has_value();
    facts.figures.push_back(sound_->state());
    facts.message = message_.empty() && !clip_->fingers().was_pressed() ? first_words : message_;
    facts.message_is_bad = message_is_bad_;
    layer_->begin(size.width, size.height, since, events_);
    events_.clear();
    panel_->draw(facts, size.width, size.height, asked_);
    drawn = layer_->draw(*commands, picture_->canvas());
    if (!drawn.ok()) return drawn;
    if (auto shown = screen_->present(std::move(*commands), picture_->canvas()); !shown.ok()) return shown;

    const auto end = Clock::now();
    last_draw_ms_ = seconds_between(begin, end) * 1000;
    panel_->remember(facts, last_draw_ms_, clip_->session().figures().ticks.solve_us);
    ++figures_.pictures;
    figures_.draw_ms.add(last_draw_ms_);
    if (first_event_) figures_.input_to_picture_ms.add(seconds_between(*first_event_, end) * 1000);
    first_event_.reset();
    return {};
}

}  // namespace

Result<PlayFigures> play_in_window(const PlayOptions& options) {
    PlayWindow window(options);
    if (auto opened = window.open(); !opened.ok()) return opened.error();
    return window.run();
}

}  // namespace touchable
