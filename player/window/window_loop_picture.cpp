#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/try.hpp"
#include "player/draw/decimation.hpp"
#include "player/draw/surface_pick.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/window_loop.hpp"

// When the window draws, and what.

namespace touchable {
namespace {

// From the begin of one picture to the next, at least: as often as screens show one, but where drawing takes
// so long that decoding would suffer. Another frame of the clip is waited for less.
constexpr double picture_pause_ms = 16, slowest_pause_ms = 50, share_of_drawing = 0.95, frame_pause_ms = 8;
constexpr double idle_pause_ms = 200;   // and at most, so that clock and figures go on
constexpr double after_input_ms = 300;  // buttons fade
// FingerTrails': a finger of the pointer is there only on its way; that of a hand is wherever it is.
constexpr double nearest_of_pointer = 0.5, nearest_of_hand = 0.125;
constexpr const char* first_words =
    "hold the left button over the picture to touch it; ? below shows all keys";
constexpr const char* first_touch_words =
    "put a finger on the picture to touch it; two fingers turn it, the house turns it back";

constexpr const char* end_words = "the end: Space plays it again, L repeats it";
constexpr const char* end_first_words =
    "the end: Space plays it again; hold the left button over the picture to touch it";

}  // namespace

/// When the frame came that is to be seen.
void WindowLoop::watch(const WatchedMoment* moment, Clock::time_point now) {
    if (moment && seen_.is_other_frame(*moment) && frame_came_at_ <= last_picture_) frame_came_at_ = now;
}

/// Another frame of the clip is drawn at once. Of the one that is seen nothing is drawn again where nothing
/// has moved, nor where the next would come late for it.
bool WindowLoop::is_due(const WatchedMoment* moment, Clock::time_point now) const {
    const double since_ms = 1000 * seconds_between(last_picture_, now);
    if (!clip_)
        return since_ms >=
               (1000 * seconds_between(last_event_, now) < after_input_ms ? picture_pause_ms : idle_pause_ms);
    if (!moment || since_ms < frame_pause_ms) return false;
    if (seen_.is_other_frame(*moment)) return true;
    if (since_ms < pause_ms()) return false;
    const PlaybackState playback = clip_->session().playback();
    const double left_ms = frame_ms() - 1000 * seconds_between(frame_came_at_, now);
    // One that is overdue by as much again is not waited for.
    if (playback.playing && !playback.at_end && left_ms < redraw_.ms() && left_ms > -frame_ms()) return false;
    const bool has_input =
        is_inviting_ || !events_.empty() || 1000 * seconds_between(last_event_, now) < after_input_ms;
    return has_input || since_ms >= idle_pause_ms ||
           seen_.differs(*moment, clip_->shown(), clip_->sizes().finger_radius / 50);
}

double WindowLoop::pause_ms() const {
    return std::clamp(redraw_.ms() / share_of_drawing, picture_pause_ms, slowest_pause_ms);
}

/// From one of the clip's frames to the next, as it is played.
double WindowLoop::frame_ms() const {
    const auto rate = static_cast<double>(clip_->session().playback().rate) / 1000;
    return 1000 / clip_->scene().rate.per_second() / std::max(rate, 1e-3);
}

/// Of the size in which there is time to draw.
ViewCamera WindowLoop::drawn_camera(const ScreenSize& size) const {
    const double share = picture_.graphics().can_stretch() ? governor_.share() : 1;
    const auto side = [share](int pixels) {
        return std::max(1, static_cast<int>(std::lround(pixels * share)));
    };
    return clip_->view().camera(side(size.width), side(size.height));
}

/// Which of the surface's vertices are drawn: while the clip plays no more than there is time for, at rest
/// all.
int WindowLoop::vertex_step(const ViewCamera& camera) {
    const int coarse = Decimation::step_for(clip_->view().pixels_per_vertex(camera.width, camera.height));
    coarse_saves_ = coarse > 1;
    const PlaybackState playback = clip_->session().playback();
    return governor_.coarse() && playback.playing && !playback.at_end ? coarse * governor_.step() : 1;
}

Result<void> WindowLoop::draw_what_is_there(const WatchedMoment* moment) {
    if (!clip_) return draw_opening();
    return moment ? draw(*moment) : Result<void>();
}

/// With all that was done until now.
Result<void> WindowLoop::draw_newest() {
    return draw_what_is_there(clip_ ? clip_->session().look() : nullptr);
}

/// A finger of its that touches nothing is not drawn then: it would look as if it were behind the bar.
bool WindowLoop::pointer_is_on_bar() const {
    const PointerFingers& fingers = clip_->fingers();
    const auto& at = fingers.pointer();  // where keys have moved it, too
    return at && !options_.hand && !fingers.is_touched() && !pointer_.holds() &&
           panel_->is_bar(at->x, at->y) && panel_->covers(at->x, at->y);
}

Result<void> WindowLoop::draw(const WatchedMoment& moment) {
    const ScreenSize size = screen_->size();
    const auto begin = Clock::now();
    const double since = seconds_between(last_picture_, begin);
    const bool is_new = seen_.is_other_frame(moment);
    last_picture_ = begin;
    seen_.remember(moment, clip_->shown());
    if (size.width < 1 || size.height < 1) {  // minimised
        events_.clear();
        return {};
    }
    notices_.pass(time_s_);
    if (auto fitted = fit_words(size); !fitted.ok()) return fitted;

    const HeightField field(clip_->scene(), moment.held.pair);
    clip_->view().leave_below(study_strip(size));
    const ViewCamera camera = clip_->view().camera(size.width, size.height);
    if (const auto at = pointer_.take_double_click())
        if (const auto met = pick(field, camera, at->x, at->y)) clip_->view().look_at(met->point);
    measure(moment, field, camera);
    if (is_inviting_) show_how(field, camera);
    std::vector<Contact> met;
    for (const WatchedFinger& finger : moment.felt.fingers) met.push_back(finger.contact);
    if (!options_.hand) clip_->fingers().intend(field, camera, met);

    WindowGraphics& graphics = picture_.graphics();
    if (auto begun = graphics.begin(); !begun.ok()) return begun;
    // What a session felt last is not felt any more once it has ended.
    const WatchedTick felt = clip_->session().running() ? moment.felt : WatchedTick{};
    auto marks = clip_->trails().marks(felt, clip_->shown(), field,
                                       options_.hand ? nearest_of_hand : nearest_of_pointer);
    // A dent would change what the colours of an overlay say.
    clip_->put_on_surface(marks, felt, field, is_dented_ && picture_.overlay() == Overlay::colour);
    if (study_ && !study_->gives_force()) hide_forces(marks, field);
    if (pointer_is_on_bar())
        for (FingerMark& mark : marks) mark.shown = mark.shown && mark.touching;
    const auto marked = Clock::now();
    picture_.set_tint(brush_.tint());
    const ViewCamera drawn_from = drawn_camera(size);
    if (auto drawn = picture_.draw(moment, field, drawn_from, marks, clip_->sizes(), size.width, size.height,
                                   vertex_step(drawn_from));
        !drawn.ok())
        return drawn;
    const auto drawn = Clock::now();
    if (kiosk_) look_for_labels(moment);
    PanelFacts facts = words_of(moment, field, camera);
    facts.halos = finger_halos(marks, clip_->sizes(), field, camera);
    layer_->begin(size.width, size.height, since, std::exchange(events_, {}));
    panel_->draw(facts, size.width, size.height, asked_);
    layer_->end();
    const auto worded = Clock::now();
    if (auto shown = graphics.finish(); !shown.ok()) return shown;
    if (is_new) {
        figures_.surface_ms.add(1000 * seconds_between(marked, drawn));
        figures_.words_ms.add(1000 * seconds_between(drawn, worded));
        figures_.shown_ms.add(1000 * seconds_between(worded, Clock::now()));
    }
    if (film_ && film_->wants(now_s())) {
        TRY_ASSIGN(auto picture, graphics.picture());
        film_->add(std::move(picture));
    }
    note_picture(facts, begin);
    note_frame(moment, is_new);
    return {};
}

/// All that is shown in words, bars and curves.
PanelFacts WindowLoop::words_of(const WatchedMoment& moment, const HeightField& field,
                                const ViewCamera& camera) {
    PanelFacts facts = panel_facts(*clip_, picture_, moment, field, camera);
    facts.settings.b_is_on = settings_.in_effect.b_is_on;
    facts.settings.relief = relief_words();
    facts.brush = brush_.facts();
    facts.measure = measure_.facts(camera, clip_->scene());
    if (facts.place.pixel)
        if (const auto words = brush_.segment_words(moment, facts.place.pixel->x, facts.place.pixel->y);
            !words.empty())
            facts.place.lines.insert(facts.place.lines.begin() + 1, words);
    facts.is_dented = is_dented_;
    facts.is_turning = is_turning_;
    facts.has_touch_screen = has_touch_screen();
    facts.clips = playlist_.size();
    facts.figures.push_back(sound_->state());
    for (std::string words : {screen_->touch_state(), sound_->rumble_state()})
        if (!words.empty()) facts.figures.push_back(std::move(words));
    facts.volume = sound_->volume();
    if (kiosk_) {
        facts.kiosk.emplace(kiosk_facts(facts));
        if (facts.hand) put_in_kiosk_words(facts.hand->state);
        if (study_) facts.study = study_facts();
        return facts;
    }
    const std::string& passing = notices_.passing();
    facts.message = passing;
    facts.message_is_bad = notices_.is_refusal();
    facts.faults = {notices_.faults().begin(), notices_.faults().end()};
    const auto failure =
        clip_->session().running() ? clip_->session().clip_failure() : clip_->session().failure();
    if (passing.empty() && !words_of_opening().empty()) {
        facts.message = words_of_opening();
        facts.message_is_bad = false;
        return facts;
    }
    if (!passing.empty()) return facts;
    if (facts.message = brush_.words(); !facts.message.empty()) {
        facts.message_is_bad = false;
        return facts;
    }
    if (!facts.faults.empty()) return facts;  // no hint beside what went wrong
    facts.message_is_bad = failure.has_value();
    const std::vector<std::string> remarks = clip_->remarks();
    const bool is_gone = facts.at_end && !remarks.empty();  // a camera
    facts.message_is_bad = facts.message_is_bad || is_gone;
    if (failure)
        facts.message = failure->message;
    else if (is_gone)
        facts.message = remarks.back();
    else if (!options_.hand && !clip_->fingers().was_pressed())
        facts.message = has_touch_screen()                   ? first_touch_words
                        : facts.at_end && !clip_->is_still() ? end_first_words
                                                             : first_words;
    else if (facts.at_end && !clip_->is_still())
        facts.message = end_words;
    return facts;
}

void WindowLoop::note_picture(const PanelFacts& facts, Clock::time_point begin) {
    // A box of words has its size one picture later.
    const std::string said = facts.message + (facts.faults.empty() ? "" : facts.faults.front()) +
                             (facts.hand ? facts.hand->state.words + facts.hand->state.remark : "");
    if (facts.place.lines.size() != place_lines_ || said != shown_message_) last_event_ = begin;
    place_lines_ = facts.place.lines.size();
    shown_message_ = said;
    const auto end = Clock::now();
    last_draw_ms_ = seconds_between(begin, end) * 1000;
    panel_->remember(facts, last_draw_ms_, clip_->session().figures().ticks.solve_us);
    if (!begun_) {
        begun_ = end;
        begun_cpu_ms_ = thread_cpu_ms();
        if (film_)
            sound_->film(
                [film = film_.get()](std::int64_t first, std::span<const StereoSample> samples) {
                    film->add_sound(first, samples);
                },
                end);
        figures_.first_picture_ms = 1000 * seconds_between(asked_for_, end);
    }
    ++figures_.pictures;
    figures_.draw_ms.add(last_draw_ms_);
    if (first_event_) figures_.input_to_picture_ms.add(seconds_between(*first_event_, end) * 1000);
    first_event_.reset();
}

/// Whether the picture was there in time, and how large the next one is to be.
void WindowLoop::note_frame(const WatchedMoment& moment, bool is_new) {
    if (!is_new) {
        redraw_.add(last_draw_ms_);
        return;
    }
    redraw_.add_frame();
    const PlaybackState playback = clip_->session().playback();
    const std::int64_t due = frames_shown_.due(), in_time = frames_shown_.in_time();
    const TimedFrame& frame = moment.held.pair.prev;
    const std::int64_t lasts_ns = clip_->scene().rate.time_ns(frame.number + 1) - frame.time_ns;
    frames_shown_.add(moment.held.pair, playback.moment.time_ns, lasts_ns);
    if (playback.playing)
        governor_.add(now_s(), frames_shown_.due() - due, frames_shown_.in_time() - in_time,
                      last_draw_ms_ / frame_ms(), coarse_saves_);
    figures_.least_detail = std::min(figures_.least_detail, governor_.detail());
}

}  // namespace touchable
