// When the window draws, and what: with a clip, and as long as there is none.

#include "player/window/window_loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/draw/pictures.hpp"
#include "player/draw/view.hpp"
#include "player/window/measure.hpp"

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

/// What is under the pointer, to be read at a glance.
PlaceFacts place_facts(const OpenedClip& clip, const WatchedMoment& moment, const HeightField& field,
                       const ViewCamera& camera) {
    const auto pointer = clip.fingers().looked_at();
    if (!pointer) return {};
    const auto met = pick(field, camera, pointer->x, pointer->y);
    if (!met) return {};
    const Scene& scene = clip.scene();
    const int x = static_cast<int>(std::lround(met->x)), y = static_cast<int>(std::lround(met->y));
    const PixelValues values = values_at(field, moment.held.pair, x, y);
    PlaceFacts place{{formatted("pixel %d, %d", x, y)}};
    std::vector<std::string>& lines = place.lines;
    if (moment.stored && !moment.stored->depth.empty())
        lines[0] += ", " + stored_in_words(moment.stored->depth, scene, x, y);
    if (values.valid) {
        const bool is_range = scene.depth.semantics == DepthSemantics::range;
        lines.push_back("z " + metres_in_words(values.z, scene) +
                        (is_range ? ", ray " + metres_in_words(values.depth, scene) : "") +
                        (values.height_mm != 0 ? formatted(", height %.2f mm", values.height_mm) : ""));
    }
    if (!met->drawn) {
        lines.insert(lines.end(), {values.valid ? "an edge:" : "no depth here:", "nothing to touch"});
        return place;
    }
    place.pixel = {x, y};
    if (!values.valid) return place;
    lines.push_back(formatted("stiffness %.2g N/mm of the hand", values.properties.stiffness / 1000));
    lines.push_back(formatted("friction %.2f, sliding %.2f", values.properties.static_friction,
                              values.properties.dynamic_friction));
    return place;
}

/// How well the machine keeps up.
std::vector<std::string> figure_words(const OpenedClip& clip, const ClipPicture& picture,
                                      const WatchedMoment& moment) {
    const WatchedFigures figures = clip.session().figures();
    const auto frame = static_cast<long long>(moment.held.pair.prev.number);
    return {clip.frames() > 0 ? formatted("frame %lld of %lld", frame, static_cast<long long>(clip.frames()))
                              : formatted("frame %lld", frame),
            formatted("%lld frames late, %lld left out", static_cast<long long>(figures.late_frames),
                      static_cast<long long>(figures.feed.dropped)),
            formatted("read %.1f ms, built %.1f ms", figures.feed.read_ms, figures.feed.build_ms),
            formatted("%lld of %lld ticks late", static_cast<long long>(figures.ticks.late),
                      static_cast<long long>(figures.ticks.ticks)),
            formatted("surface drawn at %dx%d", picture.drawn_width(), picture.drawn_height()) +
                (picture.drawn_step() == 1 ? std::string()
                                           : formatted(", every %d%s vertex", picture.drawn_step(),
                                                       picture.drawn_step() == 2 ? "nd" : "th")),
            "surface by the " + figures.feed.builder + " builder" +
                (clip.builder_why().empty() ? "" : ": " + clip.builder_why()),
            "picture by the " + std::string(picture.graphics().painter()) + " painter on " +
                (picture.graphics().gpu().empty() ? "the CPU" : picture.graphics().gpu())};
}

/// Whether a finger has to leave a surface that was not there before it.
bool is_inside(const WatchedTick& felt) {
    return std::any_of(felt.fingers.begin(), felt.fingers.end(), [](const WatchedTick::Finger& finger) {
        return (finger.force.reasons & guard_waiting) != 0;
    });
}

/// What there is to show of a clip at a moment, but for what the window itself knows (messages, loop).
PanelFacts panel_facts(const OpenedClip& clip, const ClipPicture& picture, const WatchedMoment& moment,
                       const HeightField& field, const ViewCamera& camera) {
    const PlaybackState state = clip.session().playback();
    PanelFacts facts;
    facts.clip = clip.name();
    facts.frame = moment.held.pair.prev.number;
    facts.seconds = static_cast<double>(state.moment.time_ns) * 1e-9;
    if (clip.frames() > 0) facts.seconds = std::min(facts.seconds, clip.seconds());
    facts.clip_seconds = clip.seconds();
    facts.last_seconds = clip.frames() > 0
                             ? static_cast<double>(clip.scene().rate.time_ns(clip.frames() - 1)) * 1e-9
                             : facts.clip_seconds;
    facts.cuts = clip.cuts();
    facts.playing = state.playing;
    facts.looping = state.loops;
    facts.at_end = state.at_end;
    facts.speed = static_cast<double>(state.rate) / 1000;
    facts.overlay = name_of(picture.overlay());
    facts.scale = picture.scale();
    facts.force_on = clip.force_is_on();
    if (const PersistentDevice* const hand = clip.hand())
        facts.hand = HandFacts{
            hand->name(), hand_state(*hand, *clip.control(), is_inside(moment.felt)), hand->age_s(),
            clip.scene().metres_per_unit / clip.control()->mapping().workspace.metres_per_scene_unit,
            hand->capabilities().buttons};
    facts.limit_newtons = clip.sizes().limit_newtons;
    facts.pressed_mm = clip.fingers().depth_m() * 1000;
    const auto fingers =
        std::min(moment.felt.fingers.size(),
                 static_cast<std::size_t>(clip.hand() ? clip.shown() : clip.fingers().present()));
    for (std::size_t k = 0; k < fingers; ++k)
        facts.forces.push_back(glm::length(moment.felt.fingers[k].force.force));
    facts.place = place_facts(clip, moment, field, camera);
    facts.settings = {clip.settings().values(), clip.in_effect(), clip.filters()};
    facts.settings.has_device = clip.hand() != nullptr;
    facts.figures = figure_words(clip, picture, moment);
    const WatchedFigures figures = clip.session().figures();
    facts.late_ticks = figures.ticks.late;
    facts.dropped_frames = figures.feed.dropped;
    return facts;
}

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
    const int coarse = SurfaceDrawing::step_for(clip_->view().pixels_per_vertex(camera.width, camera.height));
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
    TRY(fit_words(size));

    const HeightField field(clip_->scene(), moment.held.pair);
    clip_->view().leave_below(study_strip(size));
    const ViewCamera camera = clip_->view().camera(size.width, size.height);
    if (const auto at = pointer_.take_double_click())
        if (const auto met = pick(field, camera, at->x, at->y)) clip_->view().look_at(met->point);
    measure(moment, field, camera);
    if (is_inviting_) show_how(field, camera);
    std::vector<Contact> met;
    for (const WatchedTick::Finger& finger : moment.felt.fingers) met.push_back(finger.contact);
    if (!options_.hand) clip_->fingers().intend(field, camera, met);

    WindowGraphics& graphics = picture_.graphics();
    TRY(graphics.begin());
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
    TRY(picture_.draw(moment, field, drawn_from, marks, clip_->sizes(), size.width, size.height,
                      vertex_step(drawn_from)));
    const auto drawn = Clock::now();
    if (kiosk_) look_for_labels(moment);
    PanelFacts facts = words_of(moment, field, camera);
    facts.halos = finger_halos(marks, clip_->sizes(), field, camera);
    layer_->begin(size.width, size.height, since, std::exchange(events_, {}));
    panel_->draw(facts, size.width, size.height, asked_);
    layer_->end();
    const auto worded = Clock::now();
    TRY(graphics.finish());
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
    facts.faults = {notices_.faults().begin(), notices_.faults().end()};
    if (!notices_.passing().empty()) {
        facts.message = notices_.passing();
        facts.message_is_bad = notices_.is_refusal();
        return facts;
    }
    constexpr double opening_is_quick_s = 0.2;  // shorter work is not mentioned
    facts.message = opening_.seconds() > opening_is_quick_s ? opening_.words() + " ..." : brush_.words();
    if (!facts.message.empty() || !facts.faults.empty()) return facts;  // no hint beside what went wrong
    const auto failure =
        clip_->session().running() ? clip_->session().clip_failure() : clip_->session().failure();
    const std::vector<std::string> remarks = clip_->remarks();
    const bool is_gone = facts.at_end && !remarks.empty();  // a camera
    facts.message_is_bad = failure || is_gone;
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

/// Until there is a clip. A finger behind the eye makes graphics ready for those that will touch, and half
/// the size for a governor that will want it: compiling what they are drawn by would make a picture come
/// late. What is shown counts as the window's first picture only where no clip was named for it.
Result<void> WindowLoop::draw_opening() {
    const auto since = seconds_between(last_picture_, Clock::now());
    last_picture_ = Clock::now();
    first_event_.reset();
    const ScreenSize size = screen_->size();
    if (size.width < 1 || size.height < 1) {  // minimised
        events_.clear();
        return {};
    }
    notices_.pass(time_s_);
    TRY(fit_words(size));
    WindowGraphics& graphics = picture_.graphics();
    TRY(graphics.begin());
    Scene scene;
    scene.width = scene.height = 2;
    scene.camera = {1, 1, 0.5, 0.5};
    const glm::dvec3 behind(0, 0, 10);
    FingerMark finger{behind, behind, {0, 0, 1}, true, {behind, behind + 1.0}};
    finger.under = FingerMark::Under{behind, {0, 0, 1}};
    finger.given_way = {0, 0, -1};
    const int part = graphics.can_stretch() ? 2 : 1;
    const ViewCamera camera =
        own_view(scene, std::max(size.width / part, 1), std::max(size.height / part, 1), 0.1);
    if (auto drawn = graphics.draw(camera, {{finger}}, {}, size.width, size.height); !drawn) return drawn;
    PanelFacts facts;
    facts.is_empty = waits_for_wish() && !opening_.is_busy();
    if (!kiosk_) {
        facts.message_is_bad = !notices_.passing().empty() && notices_.is_refusal();
        if (!notices_.passing().empty())
            facts.message = notices_.passing();
        else if (opening_.is_busy())
            facts.message = opening_.words() + " ...";
        facts.faults = {notices_.faults().begin(), notices_.faults().end()};
    }
    for (int k = 0; k < 2; ++k) {  // a box of words has its size the second time
        layer_->begin(size.width, size.height, k == 0 ? since : 1e-3, std::exchange(events_, {}));
        panel_->draw_without_clip(facts, size.width, size.height, asked_);
        layer_->end();
    }
    TRY(graphics.finish());
    if (!begun_ && waits_for_wish()) {
        begun_ = Clock::now();
        begun_cpu_ms_ = thread_cpu_ms();
        figures_.first_picture_ms = 1000 * seconds_between(asked_for_, *begun_);
    }
    if (begun_) ++figures_.pictures;
    return {};
}

}  // namespace touchable
