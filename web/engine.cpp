// SPDX-License-Identifier: Apache-2.0
// The engine of the page: surface, touch solver, pointer, view and sound of one clip, for a browser's worker.
//
// The worker fetches and inflates pictures; all else is here, and is the engine that the program has. It is
// called by plain functions with numbers; bytes pass through `room`. A function that can fail returns 0, and
// `fault` says why, in words for a person; `table` has what page and worker know by name. In virtual time
// (`begin` with a script) `run` stops before a tick whose frames are missing; in the page's own time it takes
// those that are there.

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <ranges>
#include <string>
#include <vector>

#include "device/haptic_device.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/depth_values.hpp"
#include "engine/formats/scene_draft.hpp"
#include "engine/picture/image.hpp"
#include "engine/run/touch_run.hpp"
#include "engine/scene/plane_memory.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/audio/contact_sound.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/pointer.hpp"
#include "player/view/view.hpp"

#define EXPORTED(name) __attribute__((export_name(#name)))

namespace touchable {

// A page shows no remarks: a person sees nearest and farthest before a picture is opened.
std::optional<Remark> unit_doubt(double, std::string, Hints) {
    return {};
}
std::string remark_text(const Remark& remark) {
    return remark.what;
}

/// Commands of the page to the clip's clock, and to the hand and its view.
enum class ClockCommand { play_pause, seek, seek_by, step, rate, loop };
enum class HandCommand { count, deepen, point, force, turn, near_by, home, press };

enum Role { depth_role, haptic_role, height_role, roles };

namespace {

constexpr int pointer_fingers = PointerFingers::most, most_ticks_at_once = 1000;
constexpr double metres_per_newton = 0.004;  // an arrow's length, of the hand

/// A struct of doubles for the worker, with the names of its members as a member of a JSON object.
#define DOUBLES(type, ...)                                                       \
    constexpr const char* type##_members = "\"" #type "\":\"" #__VA_ARGS__ "\""; \
    struct type {                                                                \
        double __VA_ARGS__;                                                      \
    }

/// What the page sees of the clip and the hand. `sound`: address of its samples, floats, valid until the next
/// `aim`.
DOUBLES(Shown, tick, time, playing, at_end, loops, speed, force_on, own_view, newtons, rumble_low,
        rumble_high, fingers, sound, sound_samples, matrix[16]);
/// Of the pixel that the person looks at. `valid`: 0 in a hole, below 0 if there is none.
DOUBLES(ShownPick, valid, depth_m, stiffness, friction_static, friction_dynamic, height_mm);
DOUBLES(ShownFinger, at[2], goal[2], tip[2], newtons, touching, share, depth_mm, stiffness, friction,
        error_degrees);
struct ShownAll : Shown {
    ShownPick pick;
    ShownFinger finger[pointer_fingers];
};
/// What a person is asked about a picture of depth alone: metres of a grey level (0: it has no unit), the
/// values that may be lengths, and metres without a unit.
DOUBLES(PictureGuess, metres, white_near, least, most, near, far);

/// The numbers by name of an enum's values up to this one, as Clang calls a template's argument.
template <auto value>
std::string numbers_to() {
    std::string words = __PRETTY_FUNCTION__;  // "... [value = touchable::HandCommand::turn]"
    words.back() = '"';
    words = formatted("\"%s:%d", words.substr(words.rfind(':') + 1).c_str(), static_cast<int>(value));
    if constexpr (static_cast<int>(value) > 0)
        return numbers_to<static_cast<decltype(value)>(static_cast<int>(value) - 1)>() + "," + words;
    return words;
}

/// All that page and worker know by name, as JSON. The window's ramp comes in ten equal steps.
std::string page_table() {
    const auto colours = [](int count, auto&& colour_of) {
        return listed(std::views::iota(0, count), [&](int k) { return std::to_string(colour_of(k)); });
    };
    return formatted(
        R"({"ClockCommand":{%s},"HandCommand":{%s},"EventKind":{%s},"Role":{%s},"scene":"%s",%s,%s,%s,%s,)"
        R"("cut_ratio":%g,"hover_mm":%g,"noticed_degrees":%g,"ramp":[%s],"fingers":[%s]})",
        numbers_to<ClockCommand::loop>().c_str(), numbers_to<HandCommand::press>().c_str(),
        numbers_to<InputEvent::Kind::close>().c_str(), numbers_to<height_role>().c_str(),
        listed(numbers_of(Scene()), &SceneNumber::name, "\\n").c_str(), Shown_members, ShownPick_members,
        ShownFinger_members, PictureGuess_members, static_cast<double>(CUT_RULE_RATIO),
        -1000 * PointerFingers::hover_m, hand_thresholds::seen_degrees,
        colours(11, [](int k) { return ramp_colour(k / 10.0); }).c_str(),
        colours(pointer_fingers, finger_colour).c_str());
}

/// What is kept of a clip when it goes back to its beginning. A still picture is a clip of one frame.
struct OpenedClip {
    Scene scene;
    std::int64_t frames = 1;
    bool is_live = false;
    double error_bars_to = 0;  // MeasuredDepth::error_bars_to
    /// The frame that is being put together. A plane's memory is new whenever its samples are.
    RawFrame raw{};
    std::array<std::shared_ptr<const std::vector<std::uint8_t>>, roles> samples{};
};

int canvas_width = 1, canvas_height = 1;  // pixels

/// A clip that is played and touched: its frames, surface and clock, and the hand on it.
class Clip : NonCopyable {
public:
    /// At the clip's beginning, with so many fingers. A script has a goal for each finger of each tick, and
    /// all commands to the clip's clock.
    explicit Clip(OpenedClip opened, int fingers = pointer_fingers, std::vector<glm::dvec3> script = {},
                  std::vector<PlaybackCommand> commands = {})
        : opened_(std::move(opened)),
          script_(std::move(script)),
          count_(fingers),
          run_(surface_,
               std::make_shared<PlaybackLog>(std::move(commands), script_.empty() ? room_for_commands : 0)) {}
    const OpenedClip& opened() const { return opened_; }

    // ---- Frames

    /// Makes samples the newest picture of a plane.
    void set_plane(Role role, PlaneView form, std::vector<std::uint8_t> samples) {
        opened_.samples[role] = std::make_shared<std::vector<std::uint8_t>>(std::move(samples));
        form.data = opened_.samples[role]->data();
        opened_.raw.*std::array{&RawFrame::depth, &RawFrame::haptic, &RawFrame::height}[role] = form;
    }

    Result<void> take_packet(Role role, int bytes_per_sample, int channels,
                             std::span<const std::uint8_t> packet) {
        const PlaneView form = packed_plane(nullptr, scene_.width, scene_.height, bytes_per_sample, channels);
        const auto head = rank_head(packet, pixel_count(form.width, form.height * channels));
        std::vector<std::uint8_t> samples;
        if (!head || !take_rank_plane(*head, packet.subspan(head->bytes), form, samples))
            return input_error("the clip is damaged: a packet holds no picture of its size");
        set_plane(role, form, std::move(samples));
        return {};
    }

    /// The frame that is to be given next; -1: none, or no room for one.
    std::int64_t wanted() {
        asked_ = std::max(moment_.epoch, surface_.place().epoch);
        return needed();
    }

    /// Builds and publishes the frame that was wanted, of the planes that were taken.
    Result<void> give(std::int64_t number) {
        needed();
        ReadPlace place = surface_.place();
        // A clip that looped meanwhile shows the frame all the same, as the next one may be as late.
        const bool has_looped = place.epoch > asked_;
        if (has_looped &&
            (remembers_ || !state_.playing || !state_.loops || moment_.start_ns != state_.loop_begin_ns))
            return {};  // it was sent elsewhere
        RawFrame raw = opened_.raw;
        raw.epoch = place.epoch;
        raw.number = number;
        raw.time_ns = opened_.is_live ? std::max(surface_.timeline().newest_time() + 1, tick_ * tick_ns)
                      : has_looped    ? moment_.time_ns
                                      : scene_.rate.time_ns(number);
        raw.storage = std::make_shared<decltype(opened_.samples)>(opened_.samples);
        TRY_ASSIGN(const auto published, surface_.give({std::move(raw), number >= place.first_shown}));
        is_full_ = !published;  // until a tick has passed
        if (is_full_) return {};
        place.next_number =
            std::max(place.next_number, 1 + (has_looped ? scene_.rate.frame_at(moment_.time_ns) : number));
        surface_.go_to(place);
        // In a loop the hand waits for two frames; a late page has one at a time.
        if (script_.empty() && (has_looped || place.next_number > number + 1))
            surface_.timeline().end_epoch();
        return {};
    }

    // ---- Ticks

    /// Runs ticks up to this one; one of a script stops before a tick whose frames are missing. Returns how
    /// many.
    Result<int> run(int ticks) {
        TRY(control_.go_on(&run_.pair()));
        if (ticks > most_ticks_at_once && script_.empty())
            tick_ += std::exchange(ticks, 1) - 1;  // a gap for the hand
        for (int done = 0; done < ticks; ++done) {
            TRY_ASSIGN(const bool has_run, run_tick());
            if (!has_run) return done;
        }
        return ticks;
    }

    /// A moment of the run (TouchRun::save), which another clip of these pictures takes up after its first
    /// tick.
    Result<std::vector<std::uint8_t>> save() {
        if (opened_.is_live || !hand_)
            return usage_error("a live clip, or one without a tick, has no moment to save");
        return run_.save();
    }
    Result<void> load(std::span<const std::uint8_t> moment) {
        if (opened_.is_live || !hand_)
            return usage_error("a moment is taken up by a clip that has had a tick");
        TRY(run_.load(moment));
        moment_ = run_.moment();
        resumes_ = true;
        return {};
    }

    /// A live source has no clock to command.
    Result<void> command(ClockCommand verb, double number) {
        if (opened_.is_live) return {};
        using enum ClockCommand;
        if (verb == seek) control_.seek_to(number);
        if (verb == seek_by) control_.seek_by(number);
        if (verb == play_pause) return control_.play_or_pause();
        if (verb == step) return control_.step(number);
        if (verb == rate) return control_.set_speed(number);
        if (verb == loop && end_ns() >= shortest_loop_ns) return control_.toggle_loop();
        return {};
    }

    // ---- Hand and view

    void command(HandCommand verb, double a, double b) {
        using enum HandCommand;
        if (!hand_) return;
        if (verb == count) hand_->fingers.set_count(std::clamp(static_cast<int>(a), 1, pointer_fingers));
        if (verb == deepen) hand_->fingers.deepen(a);
        if (verb == point) hand_->pointer.move_by({a, b}, canvas_width, canvas_height, hand_->fingers);
        if (verb == force) hand_->device.set_force(!hand_->device.force_is_on());
        if (verb == turn) hand_->view.turn(a, b);
        if (verb == near_by) hand_->view.near_by(a);
        if (verb == home) hand_->view.go_home();
        if (verb == press) hand_->fingers.press(a > 0);
    }
    void event(const InputEvent& event, double pen, bool turns) {
        if (!hand_) return;
        const HeightField field = run_.field();
        if (is_touch(event)) {
            using enum TouchInput::Ground;
            const bool meets =
                !turns && PointerFingers::ground_at(field, hand_->camera(), {event.x, event.y});
            hand_->touches.take(event, meets ? surface : nothing, {&hand_->fingers, &hand_->view},
                                canvas_width, canvas_height);
            return;
        }
        hand_->pointer.take(event, turns ? PointerInput::Leads::view : PointerInput::Leads::fingers,
                            hand_->fingers, hand_->view, canvas_width, canvas_height);
        // A pen presses as deep as it is pressed.
        if (pen > 0 || hand_->by_pen) {
            hand_->fingers.lift();
            hand_->fingers.deepen(pen * (PointerFingers::deepest_m - PointerFingers::hover_m));
        }
        hand_->by_pen = pen > 0;
    }

    /// Once a picture: sets the fingers' goals for the next ticks, and takes the sound of the last ones.
    void aim() {
        if (!hand_) return;
        const HeightField field = run_.field();
        hand_->view.note_middle(field);
        if (script_.empty()) hand_->fingers.intend(field, hand_->camera(), felt_.contacts);
        heard_ = std::exchange(samples_, {});
    }

    /// What is to be seen and heard.
    ShownAll look() const {
        ShownAll shown{{}, {.valid = -1}};
        shown.playing = state_.playing && !state_.at_end;
        if (!hand_) return shown;
        const HeightField field = run_.field();
        const ViewCamera camera = hand_->camera();
        shown.tick = static_cast<double>(tick_);
        shown.time = 1e-9 * static_cast<double>(state_.moment.time_ns);
        shown.at_end = state_.at_end;
        shown.loops = state_.loops;
        shown.speed = static_cast<double>(state_.rate) / 1000;
        shown.force_on = hand_->device.force_is_on();
        shown.own_view = hand_->view.own();
        for (int k = 0; k < 16; ++k) shown.matrix[k] = camera.clip_from_lattice[k / 4][k % 4];
        const int count = std::min(script_.empty() ? hand_->fingers.shown() : count_, pointer_fingers);
        for (int k = 0; k < count; ++k)
            if (const auto finger = shown_finger(static_cast<std::size_t>(k), field, camera)) {
                shown.finger[static_cast<int>(shown.fingers++)] = *finger;
                shown.newtons = std::max(shown.newtons, finger->newtons);
            }
        if (const auto at = hand_->fingers.looked_at()) shown.pick = shown_values(field, camera, *at);
        shown.sound = static_cast<double>(reinterpret_cast<std::uintptr_t>(heard_.data()));
        shown.sound_samples = static_cast<double>(heard_.size());
        shown.rumble_low = rumble_.low;
        shown.rumble_high = rumble_.high;
        return shown;
    }

    // ---- What is drawn and heard

    std::int64_t shown_number() const { return run_.pair().nearer().number; }
    /// A picture of the frame nearest in time, row by row, by role: planar depths as floats, 0 where there
    /// are none, haptic samples as they are, or heights of 16 bits. Null: the frame has none.
    const void* drawn(Role role) {
        FramePair one;
        one.prev = one.next = run_.pair().nearer();
        const SurfaceFrame* const frame = one.prev.frame;
        if (!frame) return nullptr;
        if (role == haptic_role) return frame->haptic.empty() ? nullptr : frame->haptic.data();
        if (role == height_role) return frame->heights.empty() ? nullptr : frame->heights.data();
        drawn_ = q_of(HeightField(scene_, one));
        for (float& vertex : drawn_) vertex = vertex > 0 ? 1 / vertex : 0;
        return drawn_.data();
    }
    std::string hash() const { return run_.hash().hex(); }

private:
    /// The pointer's fingers as a device, what leads them, and what they feel.
    struct Hand {
        const Scene& scene;
        const Workspace workspace;
        const double most_newtons;
        const glm::dvec3 middle;
        PointerDevice device{pointer_fingers, workspace.to_device(glm::dvec3(0.0))};
        PointerFingers fingers{device, workspace};
        WindowView view{scene, middle};
        PointerInput pointer{};
        TouchInput touches{};
        bool by_pen = false;

        ViewCamera camera() const { return view.camera(canvas_width, canvas_height); }
    };

    /// 0: a live source has none.
    std::int64_t end_ns() const { return opened_.is_live ? 0 : scene_.rate.time_ns(opened_.frames); }
    /// As `wanted`. A late page leaves out frames, where none depends on those before.
    std::int64_t needed() {
        surface_.follow(moment_, opened_.frames);
        if (script_.empty() && !opened_.is_live && !remembers_) {
            ReadPlace place = surface_.place();
            place.next_number = std::max(place.next_number,
                                         std::min(scene_.rate.frame_at(moment_.time_ns), opened_.frames - 1));
            surface_.go_to(place);
        }
        const auto next = surface_.wanted(moment_, opened_.frames);
        return next && !is_full_ ? *next : -1;
    }

    /// What a run begins with is known once the first frame is there.
    Result<void> meet(const SurfaceFrame& first) {
        std::vector<double> depths = valid_depths(scene_, first);
        const Workspace workspace = default_workspace(scene_, quantile(depths, 0.5));
        TouchSettings settings;
        settings.metres_per_scene_unit = workspace.metres_per_scene_unit;
        TRY_ASSIGN(const auto solver, TouchSolver::create(scene_, settings));
        GuardSettings guard;
        if (opened_.is_live) guard.stale_after_ns = 250 * tick_ns;
        run_.touch(solver, guard, count_);
        hand_.reset(new Hand{scene_, workspace, guard.max_force, subject_of(run_.field()).middle});
        return hand_->device.open();
    }

    Result<bool> run_tick() {
        if (resumes_) {
            FramePair pair;
            surface_.timeline().pair_at(moment_, pair);
            if (needed() >= 0 && !surface_.has(moment_)) return false;
            TRY(run_.resume());
            resumes_ = false;
            tick_ = run_.tick();
        }
        const std::int64_t tick = tick_ + 1;
        moment_ = run_.moment_at(tick);
        const bool is_late = needed() >= 0 && !surface_.has(moment_);
        if (!run_.meet(tick) || (is_late && !script_.empty())) return false;
        tick_ = tick;
        is_full_ = false;
        if (!hand_) TRY(meet(*run_.pair().prev.frame));
        state_ = until_end(run_.playback(), scene_.rate, end_ns());
        lead(tick);
        felt_ = run_.solve();
        if (!script_.empty()) return true;
        const HeardTick heard = heard_contacts_.hear(felt_);
        rumble_ = motors_.next(heard);
        constexpr std::size_t most_samples = 48'000;  // of half a second
        ContactSound::Samples samples;
        sound_.render(heard, samples);
        for (const StereoSample& sample : samples)
            if (samples_.size() < most_samples) samples_.insert(samples_.end(), {sample.left, sample.right});
        return true;
    }

    /// The goals of this tick: the script's, whose last ones stay, or those of the pointer's fingers.
    void lead(std::int64_t tick) {
        const auto goals = run_.goals();
        if (!script_.empty()) {
            const std::size_t count = goals.size(), last = script_.size() / count - 1;
            const std::size_t at = std::min(static_cast<std::size_t>(tick), last) * count;
            std::copy_n(script_.begin() + static_cast<std::ptrdiff_t>(at), count, goals.begin());
            return;
        }
        hand_->device.read_positions(goals);
        for (glm::dvec3& goal : goals) goal = hand_->workspace.to_scene(goal);
        hand_->device.keep_clear(run_.field(), hand_->workspace, goals);
    }

    /// nullopt: the view does not show it.
    std::optional<ShownFinger> shown_finger(std::size_t k, const HeightField& field,
                                            const ViewCamera& camera) const {
        const Contact& contact = felt_.contacts[k];
        const glm::dvec3& force = felt_.forces[k].force;
        const double metres = felt_.metres_per_scene_unit;  // of the hand
        const auto at = camera.project(contact.proxy), goal = camera.project(contact.goal);
        if (!at || !goal) return {};
        const glm::dvec3 tip =
            camera.project(contact.proxy + force * (metres_per_newton / metres)).value_or(*at);
        ShownFinger finger{.at = {at->x, at->y}, .goal = {goal->x, goal->y}, .tip = {tip.x, tip.y}};
        finger.newtons = glm::length(force);
        finger.touching = contact.touching;
        finger.share = finger.newtons / hand_->most_newtons;
        finger.depth_mm = 1000 * metres * glm::length(contact.proxy - contact.goal);
        const auto under = PointerFingers::ground_at(field, camera, glm::dvec2(*at));
        if (!contact.touching && under)
            finger.depth_mm = -1000 * metres * glm::distance(contact.proxy, under->point);
        finger.stiffness = contact.properties.stiffness / 1000;
        finger.friction = contact.properties.static_friction;
        const double depth = depth_of(scene_.depth.semantics, contact.proxy);
        finger.error_degrees = depth <= opened_.error_bars_to ? contact.error_degrees : std::nan("");
        return finger;
    }

    ShownPick shown_values(const HeightField& field, const ViewCamera& camera, const glm::dvec2& at) const {
        const auto met = PointerFingers::ground_at(field, camera, at);
        if (!met) return {};
        const PixelValues values = values_at(field, run_.pair(), met->pixel().x, met->pixel().y);
        const HapticProperties& felt = values.properties;
        const double depth_m = values.z * scene_.metres_per_unit, stiffness = felt.stiffness / 1000;
        return {1, depth_m, stiffness, felt.static_friction, felt.dynamic_friction, values.height_mm};
    }

    static constexpr std::size_t room_for_commands = 100'000;

    OpenedClip opened_;
    const Scene& scene_ = opened_.scene;
    const std::vector<glm::dvec3> script_;
    const int count_;
    PlaybackState state_;
    PlaybackControl control_{scene_.rate, opened_.frames, [this] { return state_; },
                             [this](auto... command) { return run_.log().ask(command...); }};
    MediaMoment moment_;  // of the next tick
    SurfaceQueue surface_{scene_, opened_.error_bars_to > 0
                                      ? with_error_bars(make_cpu_builder(scene_), scene_)
                                      : make_cpu_builder(scene_)};
    TouchRun run_;
    const bool remembers_ = FilterPlan(scene_).remembers();
    bool is_full_ = false, resumes_ = false;
    std::uint64_t asked_ = 0;  // the epoch when a frame was wanted
    std::int64_t tick_ = -1;
    std::unique_ptr<Hand> hand_;  // once the first frame is there
    TouchTick felt_;
    HeardContacts heard_contacts_{scene_.width};
    ContactSound sound_;
    ContactRumble motors_;
    Rumble rumble_;
    std::vector<float> samples_, heard_, drawn_;
};

std::vector<std::uint8_t> inbox;
StoredImage stored;  // a picture of depth alone that a person opens
std::string text;    // that the worker reads next
std::unique_ptr<Clip> clip;

const char* told(std::string words) {
    text = std::move(words);
    return text.c_str();
}
int worked(const Result<void>& result) {
    if (!result) text = result.error().message;
    return result ? 1 : 0;
}

/// What lies in `room`, which has the alignment of any number.
template <class T>
std::span<const T> taken(std::size_t count) {
    return {reinterpret_cast<const T*>(inbox.data()), count};
}

Result<void> open_scene(std::size_t numbers, std::size_t times, double frames, bool is_live,
                        double error_bars_to) {
    const auto values = taken<double>(numbers + times);
    TRY_ASSIGN(Scene scene, scene_of_numbers(values.first(numbers)));
    if (times > 0) {
        auto rate = rate_of_own_times({&values[numbers], &values[numbers] + times});
        if (!rate) return input_error("the clip's times do not increase");
        scene.rate = std::move(*rate);
    }
    clip = std::make_unique<Clip>(
        OpenedClip{std::move(scene), static_cast<std::int64_t>(frames), is_live, error_bars_to});
    return {};
}

/// What the stored picture's values mean. `metres`: of a grey level; 0: it has no unit; nullopt: as the
/// program guesses it.
Result<SceneDraft> meaning(std::optional<double> metres, double degrees = 60) {
    SceneDraft draft;
    Scene& scene = draft.scene;
    scene.width = stored.image.width;
    scene.height = stored.image.height;
    scene.metres_per_unit = 1;
    const double focal = scene.width / 2.0 / std::tan(degrees * pi / 360);
    scene.camera = {focal, focal, (scene.width - 1) / 2.0, (scene.height - 1) / 2.0};
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near_is_high = true;
    scene.depth_bits = stored.bits;
    scene.hole_stiffness = Scene::soft_holes;
    SourceDescription known;
    if (metres > 0.0) known.metres_per_code = metres;
    DepthEvidence evidence{known};
    if (metres == 0.0) evidence.preset = preset_named("relative-inverse");
    TRY(guess_values(stored, evidence, draft));
    scene.remarks.clear();
    return draft;
}
bool has_unit(const SceneDraft& draft) {
    return draft.scene.stored.kind != StoredDepth::Kind::relative;
}

PictureGuess picture_guess;  // of the stored picture

Result<void> read_picture(int width, int height, int bits) {
    stored = {{width, height, bits / 8, 1, std::move(inbox)}};
    stored.bits = bits;
    TRY_ASSIGN(const SceneDraft draft, meaning(std::nullopt));
    const double metres = has_unit(draft) ? draft.scene.depth.scale : 0,
                 white = draft.scene.depth.near_is_high;
    picture_guess = {metres, white, 65535, 0, assumed_near, assumed_far};
    for (std::size_t k = 0; k < pixel_count(stored.image); ++k) {
        const double value = sample_at(stored.image, k);
        if (value == 0 || value == 65535) continue;
        picture_guess.least = std::min(picture_guess.least, value);
        picture_guess.most = std::max(picture_guess.most, value);
    }
    return {};
}

/// Filters are those that the picture's measurement chooses, as for one that the program opens.
Result<void> open_picture(double metres, bool is_white_near, double degrees) {
    TRY_ASSIGN(SceneDraft draft, meaning(std::nullopt, degrees));
    Scene& scene = draft.scene;
    DepthCoding& depth = scene.depth;
    if (metres > 0 || has_unit(draft)) TRY(assign(draft, meaning(metres, degrees)));
    if (!has_unit(draft) && depth.near_is_high != is_white_near) {
        depth.near_is_high = is_white_near;
        depth.kind = is_white_near ? DepthCodingKind::inverse : DepthCodingKind::linear;
    }
    constexpr double beyond = 1.05;  // of what is seen
    if (has_unit(draft)) depth.far = std::min(beyond * picture_guess.most, 65534.0) * depth.scale;
    derive_valid_range(depth);
    DepthValues values(draft);
    if (values.needs_looks(stored)) {
        values.look(stored);
        if (auto settled = values.settle(scene); !settled) return std::move(settled).error();
    }
    TRY(validate(scene));
    Image codes = values.codes(stored);
    RawFrame raw;
    raw.depth = codes.view();
    DepthEstimator estimator(scene);
    estimator.add(raw);
    const auto measured = estimator.measured();
    choose_filters(measured, all_unstated, scene);
    TRY(validate(scene));
    const double error_bars_to = measured ? measured->error_bars_to(scene.filter) : 0;
    clip = std::make_unique<Clip>(OpenedClip{std::move(scene), 1, false, error_bars_to});
    clip->set_plane(depth_role, raw.depth, std::move(codes.samples));
    return {};
}

}  // namespace

/// What the worker calls.
struct PageExports {
    /// Memory for the bytes of the next call.
    EXPORTED(room) static std::uint8_t* room(std::size_t bytes) {
        inbox.resize(bytes);
        return inbox.data();
    }
    EXPORTED(fault) static const char* fault() { return text.c_str(); }
    /// As JSON: numbers, members of structs in their order, a scene's numbers (a line each), limits, colours.
    EXPORTED(table) static const char* table() { return told(page_table()); }
    /// In `room`: the scene's numbers, and the frames' own times, ns, as doubles.
    EXPORTED(open_scene)
    static int open_scene(std::size_t numbers, std::size_t times, double frames, bool is_live,
                          double error_bars_to) {
        return worked(touchable::open_scene(numbers, times, frames, is_live, error_bars_to));
    }
    /// In `room`: a picture's values, of 8 or 16 bits.
    EXPORTED(read_picture) static int read_picture(int width, int height, int bits) {
        return worked(touchable::read_picture(width, height, bits));
    }
    EXPORTED(picture_guess) static const void* picture_guess() { return &touchable::picture_guess; }
    /// Opens the picture that was read; `metres`: of a grey level, 0: it has no unit.
    EXPORTED(open_picture) static int open_picture(double metres, bool is_white_near, double degrees) {
        return worked(touchable::open_picture(metres, is_white_near, degrees));
    }
    /// In `room`: a packet's head, and its content, inflated.
    EXPORTED(plane) static int plane(Role role, int bytes_per_sample, int channels, std::size_t size) {
        return worked(clip->take_packet(role, bytes_per_sample, channels, taken<std::uint8_t>(size)));
    }
    EXPORTED(wanted) static double wanted() { return static_cast<double>(clip->wanted()); }
    EXPORTED(give) static int give(double number) {
        return worked(clip->give(static_cast<std::int64_t>(number)));
    }
    /// Goes back to the clip's beginning. In `room`: goals, 3 doubles each, finger by finger and tick by
    /// tick, and then commands, 4 doubles each.
    EXPORTED(begin) static void begin(int fingers, std::size_t goals, std::size_t commands) {
        if (goals == 0 || fingers < 1 || goals % static_cast<std::size_t>(fingers) != 0)
            fingers = pointer_fingers, goals = commands = 0;
        const auto places = taken<glm::dvec3>(goals);
        const auto asked = taken<double>(3 * goals + 4 * commands).subspan(3 * goals);
        std::vector<PlaybackCommand> playback;
        for (std::size_t k = 0; k < asked.size(); k += 4)
            playback.push_back({std::llround(asked[k]), static_cast<PlaybackVerb>(asked[k + 1]),
                                std::llround(asked[k + 2]), std::llround(asked[k + 3])});
        OpenedClip opened = clip->opened();
        clip.reset();  // before the next one, for its memory
        clip = std::make_unique<Clip>(std::move(opened), fingers, std::vector(places.begin(), places.end()),
                                      std::move(playback));
    }
    /// -1: no tick can be run.
    EXPORTED(run) static int run(int ticks) {
        const auto done = clip->run(ticks);
        if (!done) text = done.error().message;
        return done ? *done : -1;
    }
    /// A moment in virtual time, for `load` of a clip that has had a tick: where its bytes are, and how many.
    EXPORTED(save) static const void* save() {
        auto moment = clip->save();
        if (!worked(moment ? Result<void>() : moment.error())) return nullptr;
        inbox = std::move(*moment);
        return inbox.data();
    }
    EXPORTED(saved_bytes) static std::size_t saved_bytes() { return inbox.size(); }
    /// In `room`: a moment. The frames around it are wanted next; `run` refuses others.
    EXPORTED(load) static int load(std::size_t size) { return worked(clip->load(taken<std::uint8_t>(size))); }
    EXPORTED(size) static void size(int width, int height) {
        canvas_width = width;
        canvas_height = height;
    }
    /// `button`: its bit in a browser's MouseEvent.buttons, or 0; `pen`: its pressure, 0 to 1.
    EXPORTED(event)
    static void event(InputEvent::Kind kind, int button, double x, double y, bool control, bool shift,
                      int touch, double seconds, double pen, bool turns) {
        constexpr const char* buttons[] = {"", "left", "right", "", "middle"};
        InputEvent given{kind, x, y, buttons[button % 5], control, shift};
        given.touch = touch;
        given.seconds = seconds;
        clip->event(given, pen, turns);
    }
    EXPORTED(play) static int play(ClockCommand verb, double a) { return worked(clip->command(verb, a)); }
    EXPORTED(hand) static void hand(HandCommand verb, double a, double b) { clip->command(verb, a, b); }
    EXPORTED(aim) static void aim() { clip->aim(); }
    /// Shown, ShownPick, and ShownFinger for each of its fingers; valid until the next look.
    EXPORTED(look) static const void* look() {
        static ShownAll shown;
        return &(shown = clip->look());
    }
    EXPORTED(shown_number) static double shown_number() { return static_cast<double>(clip->shown_number()); }
    EXPORTED(drawn) static const void* drawn(Role role) { return clip->drawn(role); }
    /// The forces' hash so far: 16 digits.
    EXPORTED(hash) static const char* hash() { return told(clip->hash()); }
};

}  // namespace touchable
