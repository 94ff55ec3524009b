// SPDX-License-Identifier: Apache-2.0
#include "player/window/opened_clip.hpp"

#include <glm/geometric.hpp>
#include <limits>

#include "engine/base/try.hpp"
#include "player/window/window_clock.hpp"

namespace touchable {
namespace {

bool has_loop_of(const PlaybackState& a, const PlaybackState& b) {
    if (!a.loops || !b.loops) return a.loops == b.loops;
    return a.loop_begin_ns == b.loop_begin_ns && a.loop_end_ns == b.loop_end_ns;
}

/// Whether a finger is absent, or hovers near the clip's camera, where it would hide everything else.
bool is_away(const WatchedTick::Finger& finger, const FieldProbe& probe, double nearest_share) {
    if (!std::isfinite(glm::dot(finger.goal, finger.goal))) return true;
    const Contact& contact = finger.contact;
    if (contact.touching) return false;
    if (!(contact.goal.z < 0)) return true;
    const glm::dvec3 pixel = probe.project(contact.goal);
    const auto depth = probe.depth_under(pixel.x, pixel.y);
    return depth && pixel.z < *depth * nearest_share;
}

}  // namespace

std::vector<FingerMark> FingerTrails::marks(const WatchedTick& tick, int count, const HeightField& field,
                                            double nearest_share) {
    constexpr std::int64_t trail_ticks = 500;
    constexpr double farthest_apart = 0.05;  // between pictures, of the clip's width: more breaks a trail
    const auto shown = std::min(tick.fingers.size(), static_cast<std::size_t>(count));
    const FieldProbe probe(field);
    trails_.resize(shown);
    std::vector<FingerMark> marks;
    const double gap = farthest_apart * field.width();
    for (std::size_t k = 0; k < shown; ++k) {
        const Contact& contact = tick.fingers[k].contact;
        std::deque<Place>& trail = trails_[k];
        const glm::dvec2 now(contact.pixel_x, contact.pixel_y);
        if (!contact.touching || !std::isfinite(now.x) || !std::isfinite(now.y) ||
            (!trail.empty() && glm::distance(trail.back().pixel, now) > gap))
            trail.clear();
        else
            trail.push_back({tick.tick, now});
        while (!trail.empty() && trail.front().tick + trail_ticks < tick.tick) trail.pop_front();
        FingerMark mark{contact.goal,
                        contact.proxy,
                        tick.fingers[k].force.force,
                        contact.touching,
                        {},
                        !is_away(tick.fingers[k], probe, nearest_share)};
        mark.error_degrees = contact.error_degrees;
        for (const Place& place : trail)
            if (const auto depth = probe.depth_under(place.pixel.x, place.pixel.y))
                mark.trail.push_back(probe.unproject(place.pixel.x, place.pixel.y, *depth));
        marks.push_back(std::move(mark));
    }
    return marks;
}

OpenedClip::OpenedClip(const PlayOptions& options, const ClipChoice& clip, WindowSound& sound)
    : options_(options),
      clip_(clip),
      sound_(sound),
      device_(std::make_shared<PointerDevice>(PointerFingers::most, glm::dvec3(0.0))) {
    // Unlike a PersistentDevice, its failure fails the session, and the next one reopens it.
    device_->stay_open();
    if (clip_.plugged) clip_.shared_camera = std::make_shared<SharedCamera>();
    clip_.share_clip();
}

Result<std::unique_ptr<OpenedClip>> OpenedClip::open(const PlayOptions& options, const ClipChoice& clip,
                                                     const SessionSettings& settings, WindowSound& sound) {
    std::unique_ptr<OpenedClip> made(new OpenedClip(options, clip, sound));
    TRY(made->make_ready(settings));
    return made;
}

SessionOptions OpenedClip::session_options(const SessionSettings& settings,
                                           std::shared_ptr<const PaintedSegments> painted) const {
    SessionOptions session = options_.session;
    session.clip = clip_;
    session.clip.painted = std::move(painted);
    if (!clip_.is_camera()) {  // they belong to another clip
        session.camera.reset();
        session.stale_after_ns.reset();
    }
    session.live = session.watched = true;
    session.builder.error_bars = !options_.kiosk;  // its visitors are told nothing of errors
    session.fingers = fingers_of_hand();
    session.held_device = device_;
    if (options_.hand) {
        session.held_device = options_.hand;
        session.control = std::make_shared<HandControl>(fingers_of_hand(), HandMapping{});
        if (options_.study) session.control->allow_force(false);  // until a participant's touch begins
    }
    // A pointer's finger that begins inside a surface, after a change of settings or a gap, stays there, with
    // the guard's force ramp. A device's user is not pushed out of a surface that was not entered.
    session.start_buried = !options_.hand;
    session.recorded = options_.record.has_value();
    session = with_settings(std::move(session), settings);
    if (options_.most_newtons)
        session.guard.max_force = std::min(session.guard.max_force, *options_.most_newtons);
    return session;
}

/// The largest force's arrow stays within a third of the picture.
MarkSizes OpenedClip::sizes_for(double max_newtons) const {
    constexpr double whole_newtons = 5;  // up to this limit arrows have their usual length
    MarkSizes sizes = mark_sizes(*scene_, middle_);
    sizes.length_per_newton *= std::min(1.0, whole_newtons / max_newtons);
    sizes.limit_newtons = max_newtons;
    return sizes;
}

void OpenedClip::put_on_surface(std::span<FingerMark> marks, const WatchedTick& felt,
                                const HeightField& field, bool dented) const {
    const auto& settings = session_->setup().options;
    for (std::size_t k = 0; k < marks.size(); ++k) {
        FingerMark& mark = marks[k];
        if (mark.shown) mark.under = under_finger(field, mark.proxy, sizes_.finger_radius);
        if (!error_bars_hold_at(depth_of(scene_->depth.semantics, mark.proxy)))
            mark.error_degrees = std::numeric_limits<double>::quiet_NaN();
        if (!dented || !mark.touching) continue;
        const double stiffness =
            std::min(felt.fingers[k].contact.properties.stiffness, settings.guard.max_stiffness);
        mark.given_way = given_way(mark.force, stiffness, settings.touch.metres_per_scene_unit);
    }
}

/// Takes the clip's facts from a setup with these settings.
void OpenedClip::take_over(const TouchSetup& setup, const SessionSettings& settings) {
    scene_ = setup.scene;
    settings_ = settings;
    in_effect_ = settings_in_effect(setup);
    filters_ = filters_in_words(setup.scene, setup.filters);
    builder_why_ = setup.options.builder.why;
    if (!setup.filters) return;
    clip_.measured = setup.filters;
    if (clip_.shared_clip) clip_.shared_clip->forget_first_frames();
}

Result<void> OpenedClip::make_ready(const SessionSettings& settings) {
    if (options_.hand) TRY(options_.hand->open());
    SessionOptions session = session_options(settings, clip_.painted);
    TRY_ASSIGN(auto setup, setup_from_options(session));
    TouchSetup& s = *setup;
    name_ = s.options.clip.file.filename().empty() ? s.options.clip.file.parent_path().filename().string()
                                                   : s.options.clip.file.filename().string();
    frames_ = s.feed->reader().frame_count().value_or(0);
    take_over(s, settings);
    workspace_ = s.workspace;
    workspace_.metres_per_scene_unit *= session.hand_scale;
    // No surface is in front of the clip's camera.
    device_->set_refuge(workspace_.to_device({0, 0, 0}));
    fingers_.emplace(*device_, workspace_);
    TRY_ASSIGN(const auto first, s.feed->pair_at(PlaybackClock(s.scene.rate, s.options.playback).at(0)));
    const Viewpoint::Subject subject = subject_of(HeightField(*scene_, first));
    view_.emplace(*scene_, subject.middle);
    middle_ = subject.middle;
    sizes_ = sizes_for(s.options.guard.max_force);
    ready_ = std::move(setup);
    return {};
}

/// Each part of a recording has its own film.
Result<void> OpenedClip::open_film(TouchSetup& setup) {
    if (!setup.film) return {};
    const auto fault = record_->file->fault();
    film_is_given_up_ = fault.has_value();
    if (fault) {
        setup.film->give_up(*fault);
        return {};
    }
    return setup.film->open(film_beside(*options_.record, ++films_), options_.existing);
}

/// If the film ends early, so does the recording.
Result<void> OpenedClip::finish_film() {
    const auto& film = session_->setup().film;
    if (!film) return {};
    TRY(film->finish());
    const auto fault = film->fault();
    if (fault && !film_is_given_up_) record_->file->end_with_frame(film->last_frame(), *fault);
    return {};
}

std::optional<Error> OpenedClip::record_fault() const {
    if (!record_) return std::nullopt;
    const auto& film = session_->setup().film;
    const auto fault = film ? film->fault() : std::nullopt;
    return fault ? fault : record_->file->fault();
}

Result<void> OpenedClip::begin() {
    if (options_.record) {
        TRY_ASSIGN(auto file, RecordingFile::create(*options_.record, fingers_of_hand(), options_.existing,
                                                    Pace::wall_clock, options_.names.record));
        record_ = std::make_unique<Record>(std::move(file));
        TRY(open_film(*ready_));
    }
    return start_session(std::move(ready_));
}

std::vector<double> OpenedClip::cuts() const {
    std::set<std::int64_t> frames = session_->cuts();
    frames.insert(cuts_.begin(), cuts_.end());
    std::vector<double> moments;
    for (const std::int64_t frame : frames)
        moments.push_back(static_cast<double>(scene_->rate.time_ns(frame)) * 1e-9);
    return moments;
}

Result<void> OpenedClip::start_session(std::unique_ptr<TouchSetup> setup) {
    listener_.emplace(sound_, scene_->width);
    std::vector<TouchSink*> sinks{&*listener_};
    if (record_) sinks.push_back(record_.get());
    if (options_.meter) sinks.push_back(options_.meter.get());
    TRY_ASSIGN(session_, WatchedSession::start(std::move(setup), std::move(sinks), options_.is_offline()));
    control_ = session_->setup().options.control.get();
    return {};
}

/// Chooses where the clip will be, as it plays, after `reading_ns`, when its first frames are read.
std::vector<PlaybackCommand> OpenedClip::choose_begin(Change& change, std::int64_t reading_ns) const {
    const FrameRate& rate = scene_->rate;
    const PlaybackState now = change.state = session_->playback();
    std::int64_t begin_ns = now.moment.time_ns;
    if (now.playing && !now.at_end) begin_ns += reading_ns / 1000 * now.rate;
    if (now.loops && now.playing) begin_ns = std::min(begin_ns, now.loop_end_ns - 1000 * now.rate);
    change.begin_ns = std::min(begin_ns, frames_ > 0 ? rate.time_ns(frames_) - 1 : latest_moment_ns);
    std::vector<PlaybackCommand> commands{{0, PlaybackVerb::rate, now.rate, 0},
                                          {0, PlaybackVerb::seek, change.begin_ns, 0}};
    if (now.loops) commands.push_back({0, PlaybackVerb::loop, now.loop_begin_ns, now.loop_end_ns});
    if (!now.playing) commands.push_back({0, PlaybackVerb::pause, 0, 0});
    return commands;
}

Result<OpenedClip::Change> OpenedClip::prepare(const SessionSettings& settings,
                                               std::shared_ptr<const PaintedSegments> painted) const {
    using Clock = WindowClock;
    Change change;
    change.settings = settings;
    change.painted = painted;
    Clock::time_point chosen_at;
    SessionOptions session = session_options(settings, std::move(painted));
    session.workspace = workspace_;
    // A camera's time only advances, and restarts with each run.
    session.late_playback = [&]() -> std::vector<PlaybackCommand> {
        chosen_at = Clock::now();
        if (!clip_.is_camera()) return choose_begin(change, reading_ns_);
        change.state = session_->playback();
        return {};
    };
    TRY_ASSIGN(change.setup, setup_from_options(session));
    change.reading_ns = std::chrono::nanoseconds(Clock::now() - chosen_at).count();
    if (!clip_.is_camera() && is_left_behind(change)) {
        // Chooses again with the measured time; for the clip it is a seek from the first choice.
        auto& playback = change.setup->options.playback;
        std::vector<PlaybackCommand> commands = choose_begin(change, change.reading_ns * 5 / 4);
        commands.insert(commands.begin(), playback[1]);
        playback = std::move(commands);
        TRY(change.setup->feed->pair_at(PlaybackClock(change.setup->scene.rate, playback).at(0)));
    }
    return change;
}

/// Whether no command has moved the clip elsewhere meanwhile.
bool OpenedClip::goes_on_to(const Change& change, const PlaybackState& now) const {
    return now.moment.epoch == change.state.moment.epoch && now.playing && change.state.playing &&
           now.rate == change.state.rate && has_loop_of(change.state, now);
}

/// Whether the clip has visibly played past the change's start.
bool OpenedClip::is_left_behind(const Change& change) const {
    constexpr std::int64_t bearable_ns = 100'000'000;
    const PlaybackState now = session_->playback();
    return goes_on_to(change, now) && now.moment.time_ns > change.begin_ns + bearable_ns;
}

bool OpenedClip::has_come_to(const Change& change) const {
    if (!session_->running()) return true;
    if (session_->is_asked()) return false;  // the command would be lost with the session
    const PlaybackState now = session_->playback();
    return !goes_on_to(change, now) || now.at_end || now.moment.time_ns >= change.begin_ns;
}

Result<void> OpenedClip::take(Change change) {
    end_session();
    const PlaybackState now = session_->playback();
    cuts_.merge(session_->cuts());
    const WatchedFigures before = figures();
    if (record_) {
        const TouchSetup& setup = session_->setup();
        TRY(finish_film());
        record_->file->end_part(recorded_facts(setup, record_->hash->hex()), setup.options.playback);
        TRY(open_film(*change.setup));
        record_->hash.emplace();
    }
    if (control_) change.setup->options.control->go_on_from(*control_);
    TRY(start_session(std::move(change.setup)));
    begin_listening();
    ended_ = before;
    constexpr std::int64_t least_ns = 20'000'000, most_ns = 3'000'000'000;
    reading_ns_ = std::clamp(change.reading_ns, least_ns, most_ns);
    take_over(session_->setup(), change.settings);
    clip_.painted = change.painted;
    sizes_ = sizes_for(session_->setup().options.guard.max_force);
    trails_ = FingerTrails();
    if (!clip_.is_camera() && !goes_on_to(change, now)) lead_from(change, now);
    return {};
}

/// Ignores refusals: such commands are impossible after the change.
void OpenedClip::lead_from(const Change& change, const PlaybackState& to) {
    const PlaybackState& from = change.state;
    const bool other_loop = !has_loop_of(from, to);
    const auto ask = [this](PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0) {
        (void)session_->ask(verb, first, second);
    };
    if (to.rate != from.rate) ask(PlaybackVerb::rate, to.rate);
    if (other_loop && from.loops) ask(PlaybackVerb::unloop);
    if (to.moment.time_ns != change.begin_ns) ask(PlaybackVerb::seek, to.moment.time_ns);
    if (other_loop && to.loops) ask(PlaybackVerb::loop, to.loop_begin_ns, to.loop_end_ns);
    if (to.playing != from.playing) ask(to.playing ? PlaybackVerb::play : PlaybackVerb::pause);
}

WatchedFigures with_counts_of(const WatchedFigures& earlier, WatchedFigures newest) {
    newest.feed.frames += earlier.feed.frames;
    newest.feed.dropped += earlier.feed.dropped;
    newest.ticks.ticks += earlier.ticks.ticks;
    newest.ticks.late += earlier.ticks.late;
    newest.ticks.late_us_p99 = std::max(newest.ticks.late_us_p99, earlier.ticks.late_us_p99);
    newest.late_frames += earlier.late_frames;
    return newest;
}

Result<void> OpenedClip::Record::consume(const TouchTick& tick) {
    for (const GuardedForce& force : tick.forces) hash->add(force.force);
    return file->consume(tick);
}

Result<void> OpenedClip::finish() {
    end_session();
    if (!record_) return {};
    TRY(finish_film());
    const TouchSetup& setup = session_->setup();
    return record_->file->finish(recorded_facts(setup, record_->hash->hex()), setup.options.playback);
}

}  // namespace touchable
