// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_picture.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/draw/pictures.hpp"
#include "player/run/terminal.hpp"
#include "player/view/view.hpp"
#include "player/window/window_clips.hpp"
#include "player/window/window_input.hpp"
#include "player/window/window_state.hpp"

namespace touchable {
namespace {

// Least time from the start of one picture to the next: a screen's period, or longer if drawing is so slow
// that decoding would suffer. For a new frame of the clip it is shorter.
constexpr double picture_pause_ms = 16, slowest_pause_ms = 50, share_of_drawing = 0.95, frame_pause_ms = 8;
constexpr double words_pause_ms = 200;  // while nothing moves: clock and figures may advance
constexpr double slow_words_pause_ms = 1000, slow_after_s = 5;  // the same, once bars have faded
constexpr double after_input_ms = 300, hint_s = 15;             // buttons fade; hints leave
constexpr int most_fine_pixels = 1 << 24, longest_side = 8192;  // of a picture with several samples a pixel
// FingerTrails' nearest_share: a pointer's finger is hidden far from the surface, a device's hardly ever.
constexpr double nearest_of_pointer = 0.5, nearest_of_hand = 0.125;
constexpr const char* first_words =
    "hold the left button over the picture to touch it; ? below shows all keys";
constexpr const char* first_touch_words =
    "put a finger on the picture to touch it; two fingers turn it, the house turns it back";
constexpr const char* end_words = "the end: Space plays it again, L loops it";
constexpr const char* end_first_words =
    "the end: Space plays it again; hold the left button over the picture to touch it";

/// Values at the pointer, readable at a glance.
PlaceFacts place_facts(const OpenedClip& clip, const WatchedMoment& moment, const HeightField& field,
                       const ViewCamera& camera) {
    const auto pointer = clip.fingers().looked_at();
    if (!pointer) return {};
    const auto met = pick(field, camera, pointer->x, pointer->y);
    if (!met) return {};
    const Scene& scene = clip.scene();
    const int x = met->pixel().x, y = met->pixel().y;
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
    const auto& chosen = clip.choice().measured;
    const MeasuredDepth* const measured = chosen && chosen->measured ? &*chosen->measured : nullptr;
    if (measured && values.depth > measured->trusted_to(scene.filter).value_or(values.depth))
        lines.push_back(std::string("too far: ") + not_trusted_words);
    lines.push_back(formatted("stiffness %.2g N/mm of the hand", values.properties.stiffness / 1000));
    lines.push_back(formatted("friction %.2f, sliding %.2f", values.properties.static_friction,
                              values.properties.dynamic_friction));
    const double degrees = field.error_bar(x, y).degrees;
    if (degrees >= 0 && clip.error_bars_hold_at(values.depth))
        lines.push_back(formatted("95 of 100 forces err by less than %.2g degrees", degrees));
    return place;
}

/// Figures of how well the machine keeps up.
std::vector<std::string> figure_words(const OpenedClip& clip, const ClipPicture& picture,
                                      const WatchedMoment& moment, const WatchedFigures& figures) {
    return {frame_in_words(moment.held.pair.prev.number, clip.frames()),
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

bool touches(const WatchedMoment& moment) {
    return std::ranges::any_of(moment.felt.fingers,
                               [](const WatchedTick::Finger& finger) { return finger.contact.touching; });
}

/// Whether a finger waits inside a surface that has appeared around it.
bool is_inside(const WatchedTick& felt) {
    return std::ranges::any_of(felt.fingers, [](const WatchedTick::Finger& finger) {
        return (finger.force.reasons & guard_waiting) != 0;
    });
}

/// A clip's facts at a moment, without the window's own (messages, loop).
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
    facts.is_live = clip.is_camera();
    facts.silence = clip.session().silence(moment);
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
    const WatchedFigures figures = clip.session().figures();
    facts.figures = figure_words(clip, picture, moment, figures);
    facts.late_ticks = figures.ticks.late;
    facts.dropped_frames = figures.feed.dropped;
    return facts;
}

/// Adds messages, if any.
void add_notices(PanelFacts& facts, const Notices& notices) {
    facts.faults = {notices.faults().begin(), notices.faults().end()};
    facts.message = notices.passing();
    facts.message_is_bad = !notices.passing().empty() && notices.is_refusal();
}

/// Whether a picture at rest would have more samples than one that moves.
bool can_be_finer(int most_samples, const ClipPicture& surface, const PictureGovernor& governor) {
    return most_samples > 1 || (surface.graphics().can_stretch() && governor.share() < 1);
}

/// Hides forces: puts fingers on the surface at the hand's position, without force, trail or dents.
void hide_forces(std::vector<FingerMark>& marks, const HeightField& field, double finger_radius) {
    for (FingerMark& mark : marks) {
        if (mark.touching)
            if (const auto under = under_finger(field, mark.goal, finger_radius)) {
                mark.proxy = under->foot;
                mark.under = FingerMark::Under{under->foot, under->normal, 0};
            }
        mark.goal = mark.proxy;
        mark.force = mark.given_way = glm::dvec3(0.0);
        mark.touching = false;
        mark.trail.clear();
    }
}

}  // namespace

double words_scale(const ScreenSize& size, bool from_afar) {
    constexpr double most = 4;
    const double room = std::min(size.width / 1280.0, size.height / 720.0) / size.scale;
    const double grown = std::round(4 * (from_afar ? room : std::sqrt(room))) / 4;
    return std::max(std::min(size.scale * grown, most), size.scale);
}

std::string relief_words(const WindowState& window) {
    const auto& in_effect = window.clip->in_effect();
    const auto amount = in_effect.find("relief");
    if (amount == in_effect.end() || amount->second == "0") return {};
    return window.options.names.relief(window.clip->choice().file.string(), in_effect);
}

Result<void> WindowPicture::open(const KeptSettings& kept) {
    PlayOptions& options = window_.options;
    last_picture_ = window_.time.asked_for;
    is_offline_ = options.is_offline();
    const double scale = scale_of_words(window_.screen->size());
    std::string letters;
    for (const WindowMode* const mode : window_.modes) letters += mode->letters();
    layer_.emplace(scale, letters, options.kiosk ? options.kiosk->texts.language : "");
    for (WindowMode* const mode : window_.modes) mode->begin();
    TRY(open_graphics());
    panel_.set_scale(scale);
    panel_.shown = kept.panel;
    is_dented_ = options.dent.value_or(kept.dent);
    surface_.set_light(options.light.value_or(kept.light));
    panel_.hidden = panel_.silent = is_offline_ && !options.film.has_words;
    if (!options.video) return {};
    const int rate = is_offline_ ? options.film.rate : FilmWriter::usual_rate;
    return assign(film_, WindowFilm::create(*options.video, options.existing, rate, is_offline_));
}

double WindowPicture::scale_of_words(const ScreenSize& size) const {
    return window_.options.scale.value_or(words_scale(size, window_.is_unattended()));
}

/// Adapts text sizes to a changed window size.
Result<void> WindowPicture::fit_words(const ScreenSize& size) {
    const double scale = scale_of_words(size);
    if (scale == layer_->scale()) return {};
    layer_->set_scale(scale);
    panel_.set_scale(scale);
    return surface_.graphics().take_letters();
}

/// A headless window needs no GPU, unless an option names one.
Result<std::unique_ptr<WindowGraphics>> WindowPicture::make_graphics() {
    const PlayOptions& options = window_.options;
    if (options.headless && options.painter == "cpu") return make_cpu_graphics();
    // A film's painter is the same on each run: it does not depend on times.
    auto device = options.painter == "auto" && !is_offline_ ? options.gpu->open_measured(measure_painters)
                                                            : options.gpu->open();
    const bool is_asked_for = options.painter != "auto" || options.session.builder.names_gpu();
    if (!device && options.headless && (!is_asked_for || lost_at_)) return make_cpu_graphics();
    if (!device) return device.error();
    TRY(window_.screen->attach(*device));
    return make_gpu_graphics(std::move(*device), options.painter, *window_.screen);
}

Result<void> WindowPicture::open_graphics() {
    TRY_ASSIGN(auto graphics, make_graphics());
    window_.figures.painter = graphics->painter();
    window_.figures.gpu = graphics->gpu();
    governor_ = {};
    surface_.use(std::move(graphics));
    return {};
}

/// Reopens graphics after a drawing error, once, if the GPU was lost. Touch continues meanwhile.
Result<void> WindowPicture::open_graphics_anew(const Error& error) {
    constexpr std::chrono::seconds soon(10);  // a GPU lost again this soon will be lost again
    TRY(window_.screen->health());
    const auto now = Clock::now();
    if (!surface_.graphics().is_lost() || (lost_at_ && now - *lost_at_ < soon)) return error;
    lost_at_ = now;
    surface_.use(nullptr);
    TRY(open_graphics());
    const PlayFigures& figures = window_.figures;
    window_.say(error.message + "; drawn by the " + figures.painter + " painter on " +
                    (figures.gpu.empty() ? "the CPU" : figures.gpu) + " from now on",
                Tone::fault);
    return {};
}

Result<void> WindowPicture::keep(const std::filesystem::path& name) {
    TRY_ASSIGN(auto image, surface_.graphics().picture());
    window_.screenshots.give(screenshot(std::move(image), name, window_.options.existing));
    return {};
}

void WindowPicture::begin_clip(bool goes_on) {
    if (!goes_on) surface_.set_overlay(Overlay::colour);  // a newly opened clip shows its own colours first
    values_.clear();
    forget_session();
}

Result<void> WindowPicture::draw_if_due(const WatchedMoment* moment) {
    const auto now = Clock::now();
    if (is_offline_) {
        if (!window_.time.begun || !moment || !film_->is_due(window_.time.now_s())) return {};
        const ScreenSize size = window_.screen->size();
        const int samples = window_.options.film.samples;
        const auto drawn = within_memory(
            "pictures of " + size_text(samples * size.width, samples * size.height) + " samples",
            [&]() -> Result<void> {
                TRY(draw(*moment));
                return add_to_film();
            });
        return drawn ? drawn : open_graphics_anew(drawn.error());
    }
    if (moment && seen_.is_other_frame(*moment) && frame_came_at_ <= last_picture_) frame_came_at_ = now;
    const auto since = std::max(last_picture_, window_.time.last_event);
    const bool moves = is_due(moment, now),
               rests = 1000 * Clock::seconds_between(since, now) > after_input_ms,
               is_fine = !moves && (is_fine_ || (rests && can_be_finer(most_samples(), surface_, governor_)));
    if (!moves && is_fine == is_fine_ && !words_differ(moment)) return {};
    is_at_rest_ = !moves && is_fine == is_fine_ && moment && !touches(*moment);
    is_fine_ = is_fine;
    const auto drawn = draw_what_is_there(moment);
    is_at_rest_ = false;
    return drawn ? add_to_film() : open_graphics_anew(drawn.error());
}

Result<void> WindowPicture::add_to_film() {
    if (!film_ || !window_.time.begun || !film_->wants(window_.time.now_s())) return {};
    TRY_ASSIGN(auto picture, surface_.graphics().picture());
    film_->add(std::move(picture));
    return {};
}

/// A new frame of the clip is drawn at once. The current one is redrawn only if something has moved and there
/// is time before the next frame.
bool WindowPicture::is_due(const WatchedMoment* moment, Clock::time_point now) const {
    const double since_ms = 1000 * Clock::seconds_between(last_picture_, now);
    const bool is_soon_after_input =
        1000 * Clock::seconds_between(window_.time.last_event, now) < after_input_ms;
    const OpenedClip* const clip = window_.clip.get();
    if (!clip) return is_soon_after_input && since_ms >= picture_pause_ms;
    if (!moment || since_ms < frame_pause_ms) return false;
    if (seen_.is_other_frame(*moment)) return true;
    if (since_ms < pause_ms()) return false;
    const PlaybackState playback = clip->session().playback();
    const double left_ms = frame_ms() - 1000 * Clock::seconds_between(frame_came_at_, now);
    // A frame overdue by its own duration is not waited for.
    const bool plays = playback.playing && !playback.at_end;
    if (plays && left_ms < redraw_.ms() && left_ms > -frame_ms()) return false;
    // Without input a pointer's finger that touches nothing only follows the clip's surface.
    const bool follows_frames = plays && !window_.options.hand && !touches(*moment);
    return window_.any(&WindowMode::moves_by_itself) || input_.has_events() || is_soon_after_input ||
           (!follows_frames && seen_.differs(*moment, clip->shown(), clip->sizes().finger_radius / 50));
}

/// Whether texts, bars and curves would look other than in the last picture, made anew if the pause is over.
bool WindowPicture::words_differ(const WatchedMoment* moment) {
    const auto now = Clock::now();
    const double since = Clock::seconds_between(std::max(last_picture_, last_words_), now);
    const ScreenSize size = window_.screen->size();
    const PlaybackState playback = window_.clip ? window_.clip->session().playback() : PlaybackState{};
    const bool is_slow = window_.clip && !(playback.playing && !playback.at_end) &&
                         Clock::seconds_between(window_.time.last_event, now) > slow_after_s;
    if (1000 * since < (is_slow ? slow_words_pause_ms : words_pause_ms) || size.width < 1 || size.height < 1)
        return false;
    if (film_) return true;  // it has no gaps
    last_words_ = now;
    window_.notices.pass(window_.time.script_s);
    const std::uint64_t before = layer_->hash();
    layer_->begin(size.width, size.height, since, {});
    if (!window_.clip) {
        panel_.draw_without_clip(facts_without_clip(), size.width, size.height, asked_);
    } else if (moment) {
        const HeightField field(window_.clip->scene(), moment->held.pair);
        PanelFacts facts = facts_of(*moment, field, window_.clip->view().camera(size.width, size.height));
        facts.halos = halos_;
        panel_.draw(facts, size.width, size.height, asked_);
    }
    layer_->end();
    return layer_->hash() != before;
}

/// How many samples along a pixel's side there is room for: 1 unless the view is turned, so that more smooth
/// its edges.
int WindowPicture::most_samples() const {
    const OpenedClip* const clip = window_.clip.get();
    const ScreenSize size = window_.screen->size();
    if (!clip || clip->view().own() || !surface_.graphics().can_stretch()) return 1;
    for (const int samples : {4, 2})
        if (samples * std::max(size.width, size.height) <= longest_side &&
            samples * samples * size.width * size.height <= most_fine_pixels)
            return samples;
    return 1;
}

double WindowPicture::pause_ms() const {
    return std::clamp(redraw_.ms() / share_of_drawing, picture_pause_ms, slowest_pause_ms);
}

/// Duration of a clip's frame at the current speed.
double WindowPicture::frame_ms() const {
    const OpenedClip& clip = *window_.clip;
    const auto rate = static_cast<double>(clip.session().playback().rate) / 1000;
    return 1000 / clip.scene().rate.per_second() / std::max(rate, 1e-3);
}

/// The camera at the size that there is time to draw.
ViewCamera WindowPicture::drawn_camera(const ScreenSize& size) const {
    const bool is_quick = surface_.graphics().is_quick() && governor_.share() == 1;
    const double share = is_offline_                         ? window_.options.film.samples
                         : is_fine_                          ? most_samples()
                         : is_quick                          ? std::min(most_samples(), 2)
                         : surface_.graphics().can_stretch() ? governor_.share()
                                                             : 1;
    const auto side = [share](int pixels) {
        return std::max(1, static_cast<int>(std::lround(pixels * share)));
    };
    return window_.clip->view().camera(side(size.width), side(size.height));
}

/// The decimation of vertices: only as fine as there is time for while the clip plays, 1 at rest.
int WindowPicture::vertex_step(const ViewCamera& camera) {
    const OpenedClip& clip = *window_.clip;
    const int coarse = SurfaceDrawing::step_for(clip.view().pixels_per_vertex(camera.width, camera.height));
    coarse_saves_ = coarse > 1;
    const PlaybackState playback = clip.session().playback();
    const bool plays = playback.playing && !playback.at_end;
    return !is_offline_ && plays ? std::max(1, coarse * governor_.coarse()) : 1;
}

Result<void> WindowPicture::draw_what_is_there(const WatchedMoment* moment) {
    if (!window_.clip) return draw_opening();
    return moment ? draw(*moment) : Result<void>();
}

Result<void> WindowPicture::draw_newest() {
    is_fine_ = can_be_finer(most_samples(), surface_, governor_);
    return draw_what_is_there(window_.clip ? window_.clip->session().look() : nullptr);
}

/// Its fingers that touch nothing are then hidden, as they would seem to be behind the bar.
bool WindowPicture::pointer_is_on_bar() const {
    const PointerFingers& fingers = window_.clip->fingers();
    const auto& at = fingers.pointer();  // includes moves by keys
    return at && !window_.options.hand && !fingers.is_touched() && !input_.holds_pointer() &&
           panel_.is_bar(*at) && panel_.covers(*at);
}

void WindowPicture::lead_fingers(const WatchedMoment& moment) {
    OpenedClip& clip = *window_.clip;
    const ScreenSize size = window_.screen->size();
    std::vector<Contact> met;
    for (const WatchedTick::Finger& finger : moment.felt.fingers) met.push_back(finger.contact);
    const HeightField field(clip.scene(), moment.held.pair);
    clip.view().note_middle(field);
    if (!window_.options.hand) clip.fingers().intend(field, clip.view().camera(size.width, size.height), met);
}

Result<void> WindowPicture::draw(const WatchedMoment& moment) {
    OpenedClip& clip = *window_.clip;
    const ScreenSize size = window_.screen->size();
    const auto begin = Clock::now();
    const double since = Clock::seconds_between(last_picture_, begin);
    const bool is_new = seen_.is_other_frame(moment);
    last_picture_ = begin;
    if (size.width < 1 || size.height < 1) {  // minimised
        seen_.remember(moment, clip.shown());
        input_.take_events();
        return {};
    }
    window_.notices.pass(window_.time.script_s);
    TRY(fit_words(size));

    const HeightField field(clip.scene(), moment.held.pair);
    double below = 0;
    for (const WindowMode* const mode : window_.modes) below += mode->strip_below(size);
    const double aside = window_.is_unattended() ? 0 : panel_.aside(static_cast<float>(size.width));
    clip.view().leave_free({aside / size.width, below});
    clip.view().note_middle(field);
    const ViewCamera camera = clip.view().camera(size.width, size.height);
    if (const auto at = input_.take_middle())
        if (const auto met = pick(field, camera, at->x, at->y)) clip.view().look_at(met->point);
    for (WindowMode* const mode : window_.modes) mode->prepare({moment, field, camera});
    if (!is_offline_) lead_fingers(moment);
    const bool is_held = window_.options.hand != nullptr;

    WindowGraphics& graphics = surface_.graphics();
    TRY(graphics.begin());
    // After a session's end, its last contacts no longer count.
    const WatchedTick felt = clip.session().running() ? moment.felt : WatchedTick{};
    auto marks =
        clip.trails().marks(felt, clip.shown(), field, is_held ? nearest_of_hand : nearest_of_pointer);
    // A dent would change the values that an overlay's colours show.
    clip.put_on_surface(marks, felt, field, is_dented_ && surface_.overlay() == Overlay::colour);
    if (window_.any(&WindowMode::hides_forces)) hide_forces(marks, field, clip.sizes().finger_radius);
    if (pointer_is_on_bar())
        for (FingerMark& mark : marks) mark.shown = mark.shown && mark.touching;
    const auto marked = Clock::now();
    const ViewCamera drawn_from = drawn_camera(size);
    if (!is_at_rest_ || !graphics.draw_again()) {
        TRY(surface_.draw(moment, field, drawn_from, marks, clip.sizes(), size.width, size.height,
                          vertex_step(drawn_from)));
        seen_.remember(moment, clip.shown());
        if (is_at_rest_) graphics.keep_drawn();
    }
    const auto drawn = Clock::now();
    PanelFacts facts = facts_of(moment, field, camera);
    facts.halos = halos_ = finger_halos(marks, clip.sizes(), field, camera);
    layer_->begin(size.width, size.height, since, input_.take_events());
    panel_.draw(facts, size.width, size.height, asked_);
    layer_->end();
    const auto worded = Clock::now();
    TRY(graphics.finish());
    if (is_new) {
        PlayFigures& figures = window_.figures;
        figures.surface_ms.add(1000 * Clock::seconds_between(marked, drawn));
        figures.words_ms.add(1000 * Clock::seconds_between(drawn, worded));
        figures.shown_ms.add(1000 * Clock::seconds_between(worded, Clock::now()));
    }
    note_picture(facts, begin);
    note_frame(moment, is_new);
    return {};
}

/// All contents of texts, bars and curves.
PanelFacts WindowPicture::facts_of(const WatchedMoment& moment, const HeightField& field,
                                   const ViewCamera& camera) {
    PanelFacts facts = panel_facts(*window_.clip, surface_, moment, field, camera);
    facts.settings.b_is_on = clips_.settings().in_effect.b_is_on;
    facts.settings.relief = relief_words(window_);
    facts.is_dented = is_dented_;
    facts.light = surface_.light();
    facts.has_touch_screen = input_.has_touch_screen();
    if (is_offline_) facts.figures.clear();  // they depend on the machine
    WindowSound& sound = *window_.sound;
    facts.figures.push_back(sound.state());
    for (std::string words : {window_.screen->touch_state(), sound.rumble_state()})
        if (!words.empty()) facts.figures.push_back(std::move(words));
    facts.volume = sound.volume();
    facts.files = clips_.files();
    for (WindowMode* const mode : window_.modes) mode->draw(facts, {moment, field, camera});
    if (!window_.is_unattended()) add_message(facts);
    if (!facts.place.lines.empty()) values_ = listed(facts.place.lines);
    return facts;
}

void WindowPicture::copy_values() {
    if (values_.empty()) return window_.say("point at the picture to copy its values", Tone::refusal);
    window_.screen->set_clipboard(values_);
    window_.say("copied: " + values_);
}

/// The last message; else work in progress, a fault, or a hint.
void WindowPicture::add_message(PanelFacts& facts) const {
    add_notices(facts, window_.notices);
    if (!facts.message.empty()) return;
    constexpr double opening_is_quick_s = 0.2;  // shorter work is not mentioned
    facts.message = clips_.seconds() > opening_is_quick_s ? clips_.words() + " ..." : facts.brush.work;
    if (!facts.message.empty() || !facts.faults.empty()) return;  // no hint beside a fault
    if (panel_.hidden) return;
    const OpenedClip& clip = *window_.clip;
    const auto failure = fault_of(clip);
    const std::vector<std::string> remarks = clip.remarks();
    const bool is_gone = facts.at_end && !remarks.empty();  // a camera
    facts.message_is_bad = failure || is_gone || !facts.silence.empty();
    if (failure)
        facts.message = failure->message;
    else if (is_gone)
        facts.message = remarks.back();
    else if (!facts.silence.empty())
        facts.message = facts.silence;
    else if (window_.time.script_s - window_.time.stirred_s > hint_s)
        return;
    else if (!window_.options.hand && !clip.fingers().was_pressed())
        facts.message = facts.has_touch_screen             ? first_touch_words
                        : facts.at_end && !clip.is_still() ? end_first_words
                                                           : first_words;
    else if (facts.at_end && !clip.is_still())
        facts.message = end_words;
}

void WindowPicture::note_picture(const PanelFacts& facts, Clock::time_point begin) {
    // ImGui sizes a text box one picture later.
    const std::string said = facts.message + (facts.faults.empty() ? "" : facts.faults.front()) +
                             (facts.hand ? facts.hand->state.words + facts.hand->state.remark : "");
    if (facts.place.lines.size() != place_lines_ || said != shown_message_) window_.time.last_event = begin;
    place_lines_ = facts.place.lines.size();
    shown_message_ = said;
    const auto end = Clock::now();
    last_draw_ms_ = Clock::seconds_between(begin, end) * 1000;
    const double solve_us = window_.clip->session().figures().ticks.solve_us;
    panel_.remember(facts, last_draw_ms_, is_offline_ ? 0 : solve_us);
    PlayFigures& figures = window_.figures;
    if (!window_.time.begun) begin_time(end);
    ++figures.pictures;
    figures.draw_ms.add(last_draw_ms_);
    if (const auto first = input_.take_first_event())
        figures.input_to_picture_ms.add(Clock::seconds_between(*first, end) * 1000);
}

void WindowPicture::begin_time(Clock::time_point at) {
    window_.figures.first_picture_ms = window_.time.begin(at);
    if (!film_) return;
    window_.sound->film(
        [film = film_.get()](std::int64_t first, std::span<const StereoSample> samples) {
            film->add_sound(first, samples);
        },
        [at] { return std::chrono::floor<std::chrono::milliseconds>(Clock::now() - at).count(); });
}

/// Counts whether the picture was in time, and adapts the next one's size.
void WindowPicture::note_frame(const WatchedMoment& moment, bool is_new) {
    if (!is_new) {
        if (!is_fine_) redraw_.add(last_draw_ms_);
        return;
    }
    redraw_.add_frame();
    const OpenedClip& clip = *window_.clip;
    const PlaybackState playback = clip.session().playback();
    const std::int64_t due = frames_shown_.due(), in_time = frames_shown_.in_time();
    const TimedFrame& frame = moment.held.pair.prev;
    const std::int64_t lasts_ns = clip.scene().rate.time_ns(frame.number + 1) - frame.time_ns;
    frames_shown_.add(moment.held.pair, playback.moment.time_ns, lasts_ns);
    if (playback.playing)
        governor_.add(window_.time.now_s(), frames_shown_.due() - due, frames_shown_.in_time() - in_time,
                      last_draw_ms_ / frame_ms(), coarse_saves_);
    double& least = window_.figures.least_detail;
    least = std::min(least, governor_.share());
}

PanelFacts WindowPicture::facts_without_clip() const {
    PanelFacts facts;
    facts.is_empty = clips_.waits_for_wish() && !clips_.is_opening();
    facts.files = clips_.files();
    if (window_.is_unattended()) return facts;
    add_notices(facts, window_.notices);
    if (facts.message.empty() && clips_.is_opening()) facts.message = clips_.words() + " ...";
    return facts;
}

/// Shown before the first clip. Draws a finger behind the eye to compile its programs, and at half size for
/// the governor, as compiling later would make a picture late. It counts as the window's first picture only
/// if no clip was named.
Result<void> WindowPicture::draw_opening() {
    const auto since = Clock::seconds_between(last_picture_, Clock::now());
    last_picture_ = Clock::now();
    input_.take_first_event();
    const ScreenSize size = window_.screen->size();
    if (size.width < 1 || size.height < 1) {  // minimised
        input_.take_events();
        return {};
    }
    window_.notices.pass(window_.time.script_s);
    TRY(fit_words(size));
    WindowGraphics& graphics = surface_.graphics();
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
    TRY(graphics.draw(camera, {{finger}}, {}, size.width, size.height));
    const PanelFacts facts = facts_without_clip();
    for (int k = 0; k < 2; ++k) {  // ImGui sizes a text box at the second pass
        layer_->begin(size.width, size.height, k == 0 ? since : 1e-3, input_.take_events());
        panel_.draw_without_clip(facts, size.width, size.height, asked_);
        layer_->end();
    }
    TRY(graphics.finish());
    PlayFigures& figures = window_.figures;
    if (!window_.time.begun && clips_.waits_for_wish())
        figures.first_picture_ms = window_.time.begin(Clock::now());
    if (window_.time.begun) ++figures.pictures;
    return {};
}

}  // namespace touchable
