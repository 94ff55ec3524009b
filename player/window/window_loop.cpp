#include "player/window/window_loop.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <initializer_list>
#include <iostream>
#include <utility>

#include "engine/printable.hpp"
#include "player/session/interrupt.hpp"
#include "player/view/surface_pick.hpp"
#include "player/window/panel_facts.hpp"

namespace touchable {
namespace {

using Clock = std::chrono::steady_clock;

// From the begin of one picture to the next, at least: as often as screens show one, but where drawing takes
// so long that decoding would suffer. Another frame of the clip is waited for less.
constexpr double picture_pause_ms = 16, slowest_pause_ms = 50, share_of_drawing = 0.95, frame_pause_ms = 8;
constexpr double idle_pause_ms = 200;   // and at most, so that clock and figures go on
constexpr double after_input_ms = 300;  // buttons fade
constexpr double message_s = 4;
constexpr const char* first_words =
    "move over the picture, and hold the left button to touch it; ? shows all keys";

constexpr const char* end_words = "the end: Space plays it again, L repeats it";

double seconds_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

}  // namespace

Result<void> WindowLoop::open() {
    if (options_.kiosk) kiosk_.emplace(*options_.kiosk);
    if (options_.settings_file) settings_ = SettingsFile(*options_.settings_file);
    const KeptSettings& kept = settings_.read();
    if (!options_.filters_are_stated) felt_.kept = {kept.a, kept.b};
    if (!settings_.message().empty()) say(settings_.message(), true);
    auto sound = WindowSound::create(!options_.headless, options_.sound, options_.existing);
    if (!sound.ok()) return sound.error();
    sound_ = std::move(*sound);
    if (auto opened = open_screen(kept); !opened.ok()) return opened;
    ask_for_clip(options_.session.clip);
    if (auto opened = open_parts(); !opened.ok()) return opened;
    if (auto opened = wait_for_clip(); !opened.ok() || !clip_) return opened;
    if (kiosk_ && !clip_->session().playback().loops && clip_->seconds() >= 0.1)
        say(playback_->toggle_loop());
    clip_->fingers().set_count(kept.fingers);
    panel_->shown = kept.panel;
    if (const auto overlay = overlay_after(Overlay::colour, kept.overlay); overlay.ok())
        picture_.set_overlay(*overlay);
    return {};
}

Result<void> WindowLoop::open_screen(const KeptSettings& kept) {
    ScreenOptions wanted = options_.screen;
    if (!options_.size_is_stated && kept.width > 0) {
        wanted.width = kept.width;
        wanted.height = kept.height;
    }
    fullscreen_ = wanted.fullscreen;
    if (options_.headless) {
        screen_ = make_headless_screen(wanted);
    } else {
        auto screen = open_glfw_screen(wanted);
        if (!screen.ok()) return screen.error();
        screen_ = std::move(*screen);
    }
    if (!options_.gpu)
        options_.gpu = std::make_shared<RunGpu>(options_.session.builder.gpu, screen_->extensions());
    // One for the surface and its picture: what is built on it is drawn where it lies.
    options_.session.gpu = options_.gpu;
    return {};
}

/// What draws.
Result<void> WindowLoop::open_parts() {
    const double scale = screen_->size().scale;
    layer_.emplace(scale);
    if (auto opened = open_graphics(); !opened.ok()) return opened;
    panel_.emplace(scale);
    if (!options_.video) return {};
    auto film = WindowFilm::create(*options_.video, options_.existing);
    if (!film.ok()) return film.error();
    film_ = std::move(*film);
    return {};
}

Result<PlayFigures> WindowLoop::run() {
    last_picture_ = Clock::now();
    Result<void> ended;
    const Error by_a_person{ErrorKind::interrupted,
                            "interrupted; what was asked for is written, up to there"};
    if (!clip_) {  // closed while the first one was opened
        if (interrupted()) return by_a_person;
        return std::move(figures_);
    }
    while (ended.ok() && !quit_ && !interrupted()) ended = turn();
    Result<void> kept;
    if (ended.ok() && options_.screenshot && !interrupted()) {
        if (const WatchedMoment* const last = clip_->session().look()) ended = draw(*last);
        if (ended.ok()) kept = keep_picture(*options_.screenshot);
    }
    opening_.give_up();
    // Whatever ended it: what was touched until then is kept.
    if (auto written = settings_.write(to_keep()); !written.ok()) figures_.not_kept = written.error().message;
    const Result<void> recorded = clip_->finish(), heard = sound_->finish();
    sum_up();
    if (!failure_) failure_ = clip_->failure();
    const Result<void> filmed = film_ ? film_->finish(now_s()) : Result<void>();
    if (film_) figures_.film_pictures = film_->pictures();
    if (film_) figures_.film_left_out = film_->left_out();
    if (failure_ && failure_->kind != ErrorKind::interrupted) return *failure_;
    for (const auto* done :
         std::initializer_list<const Result<void>*>{&ended, &recorded, &heard, &filmed, &kept})
        if (!done->ok()) return done->error();
    if (interrupted()) return by_a_person;
    return std::move(figures_);
}

/// Draws where something is to be seen, takes what has come, and does it.
Result<void> WindowLoop::turn() {
    const WatchedMoment* const moment = clip_->session().look();
    say(playback_->go_on(moment));
    watch(moment, Clock::now());
    if (is_due(moment, Clock::now()))
        if (auto drawn = draw(*moment); !drawn.ok())
            if (auto opened = open_graphics_anew(drawn.error()); !opened.ok()) return opened;
    if (auto there = screen_->health(); !there.ok()) return there;
    const double left_ms = pause_ms() - 1000 * seconds_between(last_picture_, Clock::now());
    const int longest_ms = clip_->session().playback().playing ? 2 : 8;  // until another frame is seen
    const auto wait = std::chrono::milliseconds(std::clamp(static_cast<int>(left_ms), 1, longest_ms));
    for (const InputEvent& event : screen_->poll(wait)) take(event);
    if (begun_) take_script();
    if (kiosk_ && begun_) watch_over();
    for (const WindowCommand& command : std::exchange(asked_, {})) take(command);
    go_on_opening();
    if (!clip_->session().running() && !begun_) quit_ = true;  // there will be no picture
    if (options_.seconds && now_s() >= *options_.seconds) quit_ = true;
    return {};
}

double WindowLoop::now_s() const {
    return begun_ ? seconds_between(*begun_, Clock::now()) : 0;
}

void WindowLoop::sum_up() {
    figures_.seconds = now_s();
    figures_.window_cpu_ms = begun_ ? thread_cpu_ms() - begun_cpu_ms_ : 0;
    figures_.frames_due = frames_shown_.due();
    figures_.frames_in_time = frames_shown_.in_time();
    count_session();
}

/// Of all clips that were there.
void WindowLoop::count_session() {
    const WatchedFigures sessions = clip_->figures();
    figures_.builder = sessions.feed.builder;
    figures_.ticks += sessions.ticks.ticks;
    figures_.late_ticks += sessions.ticks.late;
    figures_.tick_late_us_p99 = std::max(figures_.tick_late_us_p99, sessions.ticks.late_us_p99);
    figures_.frames += sessions.feed.frames;
    figures_.late_frames += sessions.late_frames;
    figures_.dropped_frames += sessions.feed.dropped;
}

/// When the frame came that is to be seen.
void WindowLoop::watch(const WatchedMoment* moment, Clock::time_point now) {
    if (moment && seen_.is_other_frame(*moment) && frame_came_at_ <= last_picture_) frame_came_at_ = now;
}

/// Another frame of the clip is drawn at once. Of the one that is seen nothing is drawn again where nothing
/// has moved, nor where the next would come late for it.
bool WindowLoop::is_due(const WatchedMoment* moment, Clock::time_point now) const {
    const double since_ms = 1000 * seconds_between(last_picture_, now);
    if (!moment || since_ms < frame_pause_ms) return false;
    if (seen_.is_other_frame(*moment)) return true;
    if (since_ms < pause_ms()) return false;
    const PlaybackState playback = clip_->session().playback();
    const double left_ms = frame_ms() - 1000 * seconds_between(frame_came_at_, now);
    // One that is overdue by as much again is not waited for.
    if (playback.playing && !playback.at_end && left_ms < small_draw_ms_ && left_ms > -frame_ms())
        return false;
    const bool has_input =
        is_inviting_ || !events_.empty() || 1000 * seconds_between(last_event_, now) < after_input_ms;
    return has_input || since_ms >= idle_pause_ms ||
           seen_.differs(*moment, clip_->fingers().shown(), clip_->sizes().finger_radius / 50);
}

double WindowLoop::pause_ms() const {
    return std::clamp(small_draw_ms_ / share_of_drawing, picture_pause_ms, slowest_pause_ms);
}

/// From one of the clip's frames to the next, as it is played.
double WindowLoop::frame_ms() const {
    const auto rate = static_cast<double>(clip_->session().playback().rate) / 1000;
    return static_cast<double>(clip_->scene().rate.time_ns(1)) * 1e-6 / std::max(rate, 1e-3);
}

/// Of the size in which there is time to draw.
ViewCamera WindowLoop::drawn_camera(const ScreenSize& size) const {
    const double share = picture_.graphics().can_stretch() ? governor_.share() : 1;
    const auto side = [share](int pixels) {
        return std::max(1, static_cast<int>(std::lround(pixels * share)));
    };
    return clip_->view().camera(side(size.width), side(size.height));
}

void WindowLoop::take_script() {
    while (scripted_ < options_.script.size() && options_.script[scripted_].seconds <= now_s()) {
        const auto& what = options_.script[scripted_++].what;
        if (const auto* event = std::get_if<InputEvent>(&what))
            take(*event);
        else
            take(std::get<WindowCommand>(what));
    }
}

void WindowLoop::take(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (kiosk_ && !is_for_visitors(event)) return;
    if (kiosk_ && is_a_visit(event)) {
        kiosk_->came(now_s());
        watch_over();  // the finger that showed how goes before the visitor's comes
    }
    last_event_ = Clock::now();
    if (!first_event_) first_event_ = last_event_;
    events_.push_back(event);
    if (event.kind == Kind::close) quit_ = true;
    if (event.kind == Kind::dropped) open_other(event.word);
    if (event.kind == Kind::key && event.word == "escape" && panel_->help_shown) {
        panel_->help_shown = false;
        return;
    }
    if (event.kind == Kind::key) {
        for (const KeyBinding& binding : key_bindings())
            if (event.word == binding.key && event.shift == binding.shift &&
                (!event.repeated || goes_by_steps(binding.verb)))
                return take(WindowCommand{binding.verb, binding.number, ""});
        return;
    }
    if (event.kind == Kind::moved) pointer_at_ = {event.x, event.y};
    const bool is_of_panel =
        layer_->holds_pointer() || (!pointer_.holds() && panel_->covers(pointer_at_.x, pointer_at_.y));
    if (is_of_panel && event.kind == Kind::moved) pointer_.leave(clip_->fingers());
    const ScreenSize size = screen_->size();
    if (!is_of_panel || event.kind == Kind::released)
        pointer_.take(event, clip_->fingers(), clip_->view(), size.width, size.height);
    screen_->hide_pointer(clip_->fingers().shown() > 0);
}

void WindowLoop::say(const Result<void>& done) {
    if (!done.ok()) say(done.error().message, true);
}

void WindowLoop::say(std::string words, bool bad) {
    // Who sees no window, or is no visitor, is told what went wrong all the same.
    if (bad && (options_.headless || kiosk_))
        std::cerr << "touchable: warning: " << printable(words, 500) << '\n';
    message_ = std::move(words);
    message_is_bad_ = bad;
    message_at_ = Clock::now();
}

Result<void> WindowLoop::draw(const WatchedMoment& moment) {
    const ScreenSize size = screen_->size();
    const auto begin = Clock::now();
    const double since = seconds_between(last_picture_, begin);
    const bool is_new = seen_.is_other_frame(moment);
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
    if (is_inviting_) show_how(field, camera);
    std::vector<glm::dvec3> goals;
    for (const WatchedFinger& finger : moment.felt.fingers) goals.push_back(finger.contact.goal);
    clip_->fingers().intend(field, camera, goals);

    WindowGraphics& graphics = picture_.graphics();
    if (auto begun = graphics.begin(); !begun.ok()) return begun;
    // What a session felt last is not felt any more once it has ended.
    const WatchedTick felt = clip_->session().running() ? moment.felt : WatchedTick{};
    const auto marks = clip_->trails().marks(felt, clip_->fingers().shown(), field);
    if (auto drawn =
            picture_.draw(moment, field, drawn_camera(size), marks, clip_->sizes(), size.width, size.height);
        !drawn.ok())
        return drawn;
    PanelFacts facts = words_of(moment, field, camera);
    facts.halos = finger_halos(marks, clip_->sizes(), field, camera);
    layer_->begin(size.width, size.height, since, std::exchange(events_, {}));
    panel_->draw(facts, size.width, size.height, asked_);
    layer_->end();
    const auto stages = graphics.finish();
    if (!stages.ok()) return stages.error();
    for (const GpuTime& stage : *stages) figures_.stage_ms[stage.label] += stage.ms;
    if (film_ && film_->wants(now_s())) {
        auto picture = graphics.picture();
        if (!picture.ok()) return picture.error();
        film_->add(std::move(*picture));
    }
    note_picture(facts, begin);
    note_frame(moment, is_new);
    return {};
}

/// All that is shown in words, bars and curves.
PanelFacts WindowLoop::words_of(const WatchedMoment& moment, const HeightField& field,
                                const ViewCamera& camera) {
    PanelFacts facts = panel_facts(*clip_, picture_, moment, field, camera);
    facts.felt.b_is_on = felt_.in_effect.b_is_on;
    facts.figures.push_back(sound_->state());
    facts.is_kiosk = kiosk_.has_value();
    if (kiosk_) facts.invited_s = kiosk_->invites(now_s());
    if (kiosk_) return facts;
    facts.message = message_;
    facts.message_is_bad = message_is_bad_;
    const auto failure =
        clip_->session().running() ? clip_->session().clip_failure() : clip_->session().failure();
    if (message_.empty() && !words_of_opening().empty()) {
        facts.message = words_of_opening();
        facts.message_is_bad = false;
        return facts;
    }
    if (!message_.empty()) return facts;
    facts.message_is_bad = failure.has_value();
    if (failure)
        facts.message = failure->message;
    else if (!clip_->fingers().was_pressed())
        facts.message = first_words;
    else if (facts.at_end)
        facts.message = end_words;
    return facts;
}

void WindowLoop::note_picture(const PanelFacts& facts, Clock::time_point begin) {
    // A box of words has its size one picture later.
    if (facts.place.lines.size() != place_lines_ || facts.message != shown_message_) last_event_ = begin;
    place_lines_ = facts.place.lines.size();
    shown_message_ = facts.message;
    const auto end = Clock::now();
    last_draw_ms_ = seconds_between(begin, end) * 1000;
    panel_->remember(facts, last_draw_ms_, clip_->session().figures().ticks.solve_us);
    if (!begun_) {
        begun_ = end;
        begun_cpu_ms_ = thread_cpu_ms();
        figures_.first_picture_ms = 1000 * seconds_between(asked_for_, end);
    }
    ++figures_.pictures;
    figures_.draw_ms.add(last_draw_ms_);
    if (first_event_) figures_.input_to_picture_ms.add(seconds_between(*first_event_, end) * 1000);
    first_event_.reset();
}

double WindowLoop::thread_cpu_ms() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

/// Whether the picture was there in time, and how large the next one is to be.
void WindowLoop::note_frame(const WatchedMoment& moment, bool is_new) {
    if (!is_new) {
        small_draw_ms_ = last_draw_ms_;
        return;
    }
    const PlaybackState playback = clip_->session().playback();
    const std::int64_t due = frames_shown_.due(), in_time = frames_shown_.in_time();
    frames_shown_.add(moment.held.pair, playback.moment.time_ns, clip_->scene().rate.time_ns(1));
    if (playback.playing)
        governor_.add(now_s(), frames_shown_.due() - due, frames_shown_.in_time() - in_time,
                      last_draw_ms_ / frame_ms());
    figures_.least_share = std::min(figures_.least_share, governor_.share());
}

Result<PlayFigures> play_in_window(const PlayOptions& options) {
    WindowLoop window(options);
    if (auto opened = window.open(); !opened.ok()) return opened.error();
    return window.run();
}

}  // namespace touchable
