// The engine of the page: surface, touch solver, pointer, view and sound of one clip, for one worker of a
// browser.
//
// The worker fetches and inflates pictures; all else is here, and is the engine that the program has. It is
// called by plain functions with numbers; bytes pass through `room`. A function that can fail returns 0, and
// `fault` says why, in words for a person. Virtual time (`begin` with a script) and the page's own time
// differ only in who waits: `run` stops before a tick whose frames are missing, or takes those that are
// there.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "device/haptic_device.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/rank_samples.hpp"
#include "engine/scene/plane_memory.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/audio/contact_sound.hpp"
#include "player/draw/view.hpp"
#include "player/run/playback.hpp"
#include "player/window/pointer.hpp"

#define EXPORTED(name) __attribute__((export_name(#name)))

namespace touchable {

std::shared_ptr<std::uint8_t> take_plane_memory(std::size_t bytes, PlaneContent) {
    return {new std::uint8_t[bytes](), std::default_delete<std::uint8_t[]>()};
}

namespace {

constexpr int pointer_fingers = PointerFingers::most, most_ticks_at_once = TouchStep::longest_gap_ticks;
constexpr std::int64_t tick_ns = 1'000'000;
constexpr double metres_per_newton = 0.004;  // an arrow's length, of the hand

/// What the page sees of a finger, as doubles.
struct ShownFinger {
    double shown, x, y, goal_x, goal_y, tip_x, tip_y, newtons, touching, share, depth_mm, stiffness, friction;
};
/// What the page sees, as doubles; worker.js has the same list.
struct Shown {
    double tick, seconds, playing, at_end, loops, rate, force_on, own_view, newtons, sound_samples,
        rumble_low, rumble_high, late_frames, fingers;
    double picked, depth_m, stiffness, static_friction, dynamic_friction, height_mm;
    ShownFinger finger[pointer_fingers];
};

/// Commands of the page; worker.js has the same numbers.
enum class PageCommand {
    play_pause,
    seek,
    seek_by,
    step,
    rate,
    loop,
    fingers,
    deepen,
    point,
    force,
    turn,
    near_by,
    home,
    press
};

/// A plane of the frame that is being put together. Its memory is new whenever its samples are.
struct RawPlane {
    PlaneView view{};
    std::shared_ptr<std::vector<std::uint8_t>> samples{};
};
enum Role { depth_role, haptic_role, height_role, roles };

/// An open clip: its frames, surface and clock, and the hand on it.
class Clip {
public:
    Clip(Scene scene, std::int64_t frames, bool is_live)
        : scene_(std::move(scene)), frames_(frames), is_live_(is_live) {}

    const Scene& scene() const { return scene_; }
    std::array<RawPlane, roles>& planes() { return planes_; }

    /// Goes back to the clip's beginning, with so many fingers. A script has a goal for each finger of each
    /// tick, and all commands to the clip's clock.
    void begin(int fingers, std::vector<glm::dvec3> script, std::vector<PlaybackCommand> commands) {
        constexpr std::size_t room_for_commands = 100'000;
        log_ = script.empty() ? std::make_shared<PlaybackLog>(std::move(commands), room_for_commands)
                              : std::make_shared<PlaybackLog>(std::move(commands));
        clock_.emplace(scene_.rate, log_);
        state_ = {};
        moment_ = {};
        timeline_ = std::make_unique<SurfaceTimeline>(4);
        builder_ = make_cpu_builder(scene_);
        remembers_ = FilterPlan(scene_).remembers();
        script_ = std::move(script);
        count_ = fingers;
        tick_ = -1;
        epoch_ = built_epoch_ = 0;
        late_ = 0;
        newest_.reset();
        pair_.reset();
        step_.reset();
        samples_.clear();
        hash_ = std::make_unique<ForceHash>();
        read_from({});
    }

    // ---- Frames, as SurfaceFeed of a run reads and publishes them

    /// The frame that is needed next; -1: none, or no room for one.
    std::int64_t wanted() {
        if (is_live_) return timeline_->acquire() ? next_number_ : -1;
        if (moment_.epoch > epoch_) {
            epoch_ = moment_.epoch;
            read_from(moment_);
        }
        if (next_number_ >= frames_ && !has_ended_) {
            has_ended_ = true;
            if (built_epoch_ == epoch_) timeline_->end_epoch();
        }
        return has_ended_ || !timeline_->acquire() ? -1 : next_number_;
    }

    /// Builds and publishes the frame that was wanted, of the planes that were taken.
    Result<void> give() {
        RawFrame raw;
        raw.number = next_number_++;
        raw.time_ns = is_live_ ? std::max(timeline_->newest_time() + 1, tick_ * tick_ns)
                               : scene_.rate.time_ns(raw.number);
        raw.epoch = epoch_;
        auto kept = std::make_shared<std::array<RawPlane, roles>>(planes_);
        raw.depth = planes_[depth_role].view;
        raw.haptic = planes_[haptic_role].view;
        raw.height = planes_[height_role].view;
        raw.storage = kept;
        if (epoch_ != built_epoch_) {
            timeline_->begin_epoch(epoch_);
            built_epoch_ = epoch_;
            newest_.reset();
        }
        const bool is_shown = raw.number >= first_shown_;
        const bool is_same =
            !remembers_ && newest_ && newest_->epoch == raw.epoch && same_touch_planes(*newest_, raw);
        if (is_same) {
            TRY_ASSIGN([[maybe_unused]] const bool has_room, timeline_->republish(raw.number, raw.time_ns));
            return {};
        }
        SurfaceFrame* const slot = timeline_->acquire();
        if (!slot) return internal_error("a frame came without room for it");
        TRY(builder_->build(raw, *slot));
        if (!is_shown) return {};
        TRY(timeline_->publish(raw.number, raw.time_ns));
        if (!remembers_) newest_ = raw;
        return {};
    }

    // ---- Ticks

    /// Runs ticks up to this one; one of a script stops before a tick whose frames are missing. Returns how
    /// many.
    int run(int ticks) {
        if (ticks > most_ticks_at_once && script_.empty()) tick_ += std::exchange(ticks, 1) - 1;  // a gap
        for (int done = 0; done < ticks; ++done)
            if (!run_tick()) return done;
        return ticks;
    }

    Result<void> command(PageCommand verb, double a, double b) {
        using enum PlaybackVerb;
        const auto ns = [this](double seconds) {
            return static_cast<std::int64_t>(std::clamp(seconds * 1e9, 0.0, static_cast<double>(last_ns())));
        };
        switch (verb) {
            case PageCommand::play_pause:
                if (is_at_end()) TRY(log_->ask(seek, 0, 0));
                return log_->ask(state_.playing && !is_at_end() ? pause : play, 0, 0);
            case PageCommand::seek:
                return log_->ask(seek, ns(a), 0);
            case PageCommand::seek_by:
                return log_->ask(seek, ns(1e-9 * static_cast<double>(state_.moment.time_ns) + a), 0);
            case PageCommand::step:
                if (a > 0) return log_->ask(step, 0, 0);
                TRY(log_->ask(pause, 0, 0));
                return log_->ask(seek, scene_.rate.time_ns(std::max<std::int64_t>(0, shown_number() - 1)), 0);
            case PageCommand::rate:
                return log_->ask(rate, std::llround(std::clamp(1000 * a, 100.0, 4000.0)), 0);
            case PageCommand::loop:
                if (a == 0 || end_ns() < shortest_loop_ns) return log_->ask(unloop, 0, 0);
                return log_->ask(loop, 0, end_ns());
            default:
                if (hand_) hand_->command(verb, a, b, width_, height_);
                return {};
        }
    }

    // ---- Hand and view

    void set_size(int width, int height) {
        width_ = width;
        height_ = height;
    }
    void event(const InputEvent& event, double pen, bool turns) {
        if (!hand_ || !pair_) return;
        const HeightField field(scene_, *pair_);
        const ViewCamera camera = hand_->view.camera(width_, height_);
        if (is_touch(event)) {
            const auto ground = PointerFingers::ground_at(field, camera, {event.x, event.y})
                                    ? TouchInput::Ground::surface
                                    : TouchInput::Ground::nothing;
            hand_->touches.take(event, turns ? TouchInput::Ground::nothing : ground,
                                {&hand_->fingers, &hand_->view}, width_, height_);
            return;
        }
        hand_->pointer.take(event, turns ? PointerInput::Leads::view : PointerInput::Leads::fingers,
                            hand_->fingers, hand_->view, width_, height_);
        // A pen presses as deep as it is pressed.
        if (pen > 0 || hand_->by_pen) {
            hand_->fingers.lift();
            hand_->fingers.deepen(pen * (PointerFingers::deepest_m - PointerFingers::hover_m));
        }
        hand_->by_pen = pen > 0;
    }

    /// Sets the fingers' goals for the next ticks, and tells what is to be seen.
    void look(Shown& shown, float* matrix) {
        shown = {};
        shown.picked = -1;
        shown.playing = state_.playing && !is_at_end();
        if (!pair_ || !step_) return;
        const HeightField field(scene_, *pair_);
        shown.tick = static_cast<double>(tick_);
        shown.seconds = 1e-9 * static_cast<double>(state_.moment.time_ns);
        shown.at_end = is_at_end();
        shown.loops = state_.loops;
        shown.rate = static_cast<double>(state_.rate) / 1000;
        shown.late_frames = static_cast<double>(late_);
        const ViewCamera camera = hand_->view.camera(width_, height_);
        if (script_.empty()) hand_->fingers.intend(field, camera, contacts_);
        shown.force_on = hand_->device.force_is_on();
        shown.own_view = hand_->view.own();
        for (int k = 0; k < 16; ++k) matrix[k] = static_cast<float>(camera.clip_from_lattice[k / 4][k % 4]);
        shown.fingers = script_.empty() ? hand_->fingers.shown() : count_;
        for (int k = 0; k < std::min(static_cast<int>(shown.fingers), pointer_fingers); ++k)
            show_finger(static_cast<std::size_t>(k), camera, shown);
        if (const auto at = hand_->fingers.looked_at()) show_values(field, camera, *at, shown);
        shown.sound_samples = static_cast<double>(samples_.size() / 2);
        shown.rumble_low = rumble_.low;
        shown.rumble_high = rumble_.high;
    }

    // ---- What is drawn and heard

    std::int64_t shown_number() const { return pair_ ? shown_frame().number : -1; }
    /// Planar depths of the frame nearest in time, 0 where there are none, and heights, row by row.
    const std::vector<float>& drawn_depths() {
        drawn_.resize(pixel_count(scene_.width, scene_.height));
        if (!pair_) return drawn_;
        FramePair one;
        one.prev = one.next = shown_frame();
        const HeightField field(scene_, one);
        const bool is_range = scene_.depth.semantics == DepthSemantics::range;
        for (int y = 0; y < scene_.height; ++y)
            for (int x = 0; x < scene_.width; ++x) {
                const FieldVertex vertex = field.vertex(x, y);
                const double along = is_range ? scene_.camera.ray_length(x, y) : 1;
                drawn_[pixel_place(x, y, scene_.width)] =
                    vertex.valid ? static_cast<float>(vertex.depth / along) : 0;
            }
        return drawn_;
    }
    const SurfaceFrame* drawn_frame() const { return pair_ ? shown_frame().frame : nullptr; }
    std::vector<float>& samples() { return samples_; }
    std::string hash() const { return hash_->hex(); }

private:
    /// The pointer's fingers as a device, and what leads them.
    struct Hand {
        Hand(const Scene& scene, const Workspace& workspace, const glm::dvec3& middle)
            : device(pointer_fingers, workspace.to_device(glm::dvec3(0.0))),
              fingers(device, workspace),
              view(scene, middle) {
            static_cast<void>(device.open());
        }
        void command(PageCommand verb, double a, double b, int width, int height) {
            switch (verb) {
                case PageCommand::fingers:
                    return fingers.set_count(std::clamp(static_cast<int>(a), 1, pointer_fingers));
                case PageCommand::deepen:
                    return fingers.deepen(a);
                case PageCommand::point:
                    return pointer.move_by({a, b}, width, height, fingers);
                case PageCommand::force:
                    return device.set_force(!device.force_is_on());
                case PageCommand::turn:
                    return view.turn(a, b);
                case PageCommand::near_by:
                    return view.near_by(a);
                case PageCommand::home:
                    return view.go_home();
                case PageCommand::press:
                    return fingers.press(a > 0);
                default:
                    return;
            }
        }

        PointerDevice device;
        PointerFingers fingers;
        WindowView view;
        PointerInput pointer;
        TouchInput touches;
        bool by_pen = false;
    };

    std::int64_t end_ns() const { return is_live_ ? latest_moment_ns : scene_.rate.time_ns(frames_); }
    std::int64_t last_ns() const { return is_live_ ? 0 : scene_.rate.time_ns(frames_ - 1); }
    bool is_at_end() const { return !is_live_ && !state_.loops && state_.moment.time_ns >= last_ns(); }
    TimedFrame shown_frame() const { return pair_->blend < 0.5 ? pair_->prev : pair_->next; }

    void read_from(const MediaMoment& moment) {
        first_shown_ = is_live_ ? next_number_ : std::min(scene_.rate.frame_at(moment.start_ns), frames_ - 1);
        next_number_ =
            std::max<std::int64_t>(0, first_shown_ - (remembers_ && !is_live_ ? temporal_warm_up_frames : 0));
        has_ended_ = false;
    }

    /// What a run begins with is known once the first frame is there.
    Result<void> meet(const SurfaceFrame& first) {
        std::vector<double> depths = valid_depths(scene_, first);
        workspace_ = default_workspace(scene_.width, scene_.camera.fx, quantile(depths, 0.5));
        workspace_.metres_per_scene_unit =
            scene_.device_metres_per_unit.value_or(workspace_.metres_per_scene_unit);
        TouchSettings settings;
        settings.metres_per_scene_unit = workspace_.metres_per_scene_unit;
        TRY_ASSIGN(auto solver, TouchSolver::create(scene_, settings));
        solver_ = std::make_unique<TouchSolver>(std::move(solver));
        GuardSettings guard;
        constexpr std::int64_t stale_ns = 250'000'000;
        if (is_live_) guard.stale_after_ns = stale_ns;
        largest_force_ = guard.max_force;
        step_ = std::make_unique<TouchStep>(*solver_, guard, script_.empty() ? pointer_fingers : count_);
        const HeightField field(scene_, *pair_);
        hand_ = std::make_unique<Hand>(scene_, workspace_, subject_of(field).middle);
        heard_ = std::make_unique<HeardContacts>(scene_.width);
        sound_ = std::make_unique<ContactSound>();
        motors_ = {};
        rumble_ = {};
        return {};
    }

    bool run_tick() {
        const std::int64_t tick = tick_ + 1;
        if (log_->is_open()) log_->take(tick);
        moment_ = clock_->at(tick);
        const bool is_late =
            wanted() >= 0 && !(built_epoch_ >= moment_.epoch && timeline_->newest_time() > moment_.time_ns);
        FramePair pair;
        const bool has_pair = timeline_->pair_at(moment_, pair);
        if ((is_late && !script_.empty()) || !has_pair) return false;
        tick_ = tick;
        late_ += is_late && !is_live_;
        pair_ = pair;
        if (!step_)
            if (const auto met = meet(*pair.prev.frame); !met) return false;
        state_ = clock_->state_at(tick);
        lead(tick);
        const TouchTick done = step_->run(tick, tick * tick_ns, scene_, pair);
        contacts_.assign(done.contacts.begin(), done.contacts.end());
        forces_.assign(done.forces.begin(), done.forces.end());
        for (const GuardedForce& force : done.forces) hash_->add(force.force);
        if (!script_.empty()) return true;
        const HeardTick heard = heard_->hear(done);
        rumble_ = motors_.next(heard);
        constexpr std::size_t most_samples = 48'000;  // of half a second
        ContactSound::Samples samples;
        sound_->render(heard, samples);
        if (samples_.size() < most_samples)
            for (const StereoSample& sample : samples)
                samples_.insert(samples_.end(), {sample.left, sample.right});
        return true;
    }

    /// The goals of this tick: the script's, whose last ones stay, or those of the pointer's fingers.
    void lead(std::int64_t tick) {
        const auto goals = step_->goals();
        if (!script_.empty()) {
            const std::size_t count = goals.size(), last = script_.size() / count - 1;
            const std::size_t at = std::min(static_cast<std::size_t>(tick), last) * count;
            std::copy_n(script_.begin() + static_cast<std::ptrdiff_t>(at), count, goals.begin());
            return;
        }
        std::array<glm::dvec3, pointer_fingers> places{};
        hand_->device.read_positions(places);
        for (std::size_t k = 0; k < goals.size(); ++k) goals[k] = workspace_.to_scene(places[k]);
    }

    void show_finger(std::size_t k, const ViewCamera& camera, Shown& shown) const {
        if (k >= contacts_.size()) return;
        const Contact& contact = contacts_[k];
        const glm::dvec3& force = forces_[k].force;
        ShownFinger& finger = shown.finger[k];
        const auto at = camera.project(contact.proxy), goal = camera.project(contact.goal);
        if (!at || !goal) return;
        const auto tip =
            camera.project(contact.proxy + force * (metres_per_newton / workspace_.metres_per_scene_unit));
        const double newtons = glm::length(force);
        finger = {1,
                  at->x,
                  at->y,
                  goal->x,
                  goal->y,
                  tip ? tip->x : at->x,
                  tip ? tip->y : at->y,
                  newtons,
                  contact.touching ? 1.0 : 0.0,
                  newtons / largest_force_,
                  1000 * workspace_.metres_per_scene_unit * glm::length(contact.proxy - contact.goal),
                  contact.properties.stiffness / 1000,
                  contact.properties.static_friction};
        shown.newtons = std::max(shown.newtons, newtons);
    }

    void show_values(const HeightField& field, const ViewCamera& camera, const glm::dvec2& at,
                     Shown& shown) const {
        const auto met = PointerFingers::ground_at(field, camera, at);
        shown.picked = met ? 1 : 0;
        if (!met) return;
        const PixelValues values = values_at(field, *pair_, static_cast<int>(std::lround(met->x)),
                                             static_cast<int>(std::lround(met->y)));
        shown.depth_m = values.z * scene_.metres_per_unit;
        shown.stiffness = values.properties.stiffness / 1000;
        shown.static_friction = values.properties.static_friction;
        shown.dynamic_friction = values.properties.dynamic_friction;
        shown.height_mm = values.height_mm;
    }

    const Scene scene_;
    const std::int64_t frames_;
    const bool is_live_;
    std::array<RawPlane, roles> planes_;
    std::shared_ptr<PlaybackLog> log_;
    std::optional<PlaybackClock> clock_;
    PlaybackState state_;
    MediaMoment moment_;  // of the next tick
    std::unique_ptr<SurfaceTimeline> timeline_;
    std::unique_ptr<SurfaceBuilder> builder_;
    bool remembers_ = false, has_ended_ = false;
    std::optional<RawFrame> newest_;
    std::uint64_t epoch_ = 0, built_epoch_ = 0;
    std::int64_t next_number_ = 0, first_shown_ = 0, tick_ = -1, late_ = 0;
    std::optional<FramePair> pair_;
    std::vector<glm::dvec3> script_;
    int count_ = 1, width_ = 1, height_ = 1;
    Workspace workspace_;
    std::unique_ptr<TouchSolver> solver_;
    std::unique_ptr<TouchStep> step_;
    double largest_force_ = 1;
    std::vector<Contact> contacts_;
    std::vector<GuardedForce> forces_;
    std::unique_ptr<ForceHash> hash_;
    std::unique_ptr<Hand> hand_;
    std::unique_ptr<HeardContacts> heard_;
    std::unique_ptr<ContactSound> sound_;
    ContactRumble motors_;
    Rumble rumble_;
    std::vector<float> samples_, drawn_;
};

std::vector<std::uint8_t> inbox;
std::string fault_text, hash_text;
std::unique_ptr<Clip> clip;
Shown shown;
std::array<float, 16> matrix;
std::vector<glm::dvec3> script;

int worked(const Result<void>& result) {
    if (!result) fault_text = result.error().message;
    return result ? 1 : 0;
}

template <class T>
std::vector<T> taken(std::size_t from, std::size_t count) {
    std::vector<T> values(count);
    std::memcpy(values.data(), inbox.data() + from * sizeof(T), count * sizeof(T));
    return values;
}

/// Makes samples the newest picture of a plane.
void set_plane(Role role, int width, int height, int bytes_per_sample, int channels,
               const std::vector<std::uint16_t>& samples) {
    RawPlane& plane = clip->planes()[role];
    const std::size_t pixels = pixel_count(width, height);
    plane.samples = std::make_shared<std::vector<std::uint8_t>>(samples.size() *
                                                                static_cast<std::size_t>(bytes_per_sample));
    for (std::size_t k = 0; k < samples.size(); ++k) {
        const std::size_t to = k % pixels * static_cast<std::size_t>(channels) + k / pixels;
        if (bytes_per_sample == 2)
            std::memcpy(plane.samples->data() + 2 * to, &samples[k], 2);
        else
            (*plane.samples)[to] = static_cast<std::uint8_t>(samples[k]);
    }
    plane.view = packed_plane(plane.samples->data(), width, height, bytes_per_sample, channels);
}

Result<void> open_scene(int numbers, int times, double frames, bool is_live) {
    const auto values = taken<double>(0, static_cast<std::size_t>(numbers + times));
    TRY_ASSIGN(Scene scene, scene_of_numbers(std::span(values).first(static_cast<std::size_t>(numbers))));
    if (times > 0) {
        auto rate = rate_of_own_times({values.begin() + numbers, values.end()});
        if (!rate) return input_error("the clip's times do not increase");
        scene.rate = std::move(*rate);
    }
    clip = std::make_unique<Clip>(std::move(scene), static_cast<std::int64_t>(frames), is_live);
    clip->begin(1, {}, {});
    return {};
}

/// A picture of depth alone: codes times a unit, seen by a camera of this angle. Filters are those that its
/// measurement chooses, as for a picture that the program opens.
Result<void> open_picture(int width, int height, double metres, double degrees) {
    const auto codes = taken<std::uint16_t>(0, pixel_count(width, height));
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.camera.fx = scene.camera.fy = width / 2.0 / std::tan(degrees * pi / 360);
    scene.camera.cx = (width - 1) / 2.0;
    scene.camera.cy = (height - 1) / 2.0;
    DepthCoding& depth = scene.depth;
    depth.kind = DepthCodingKind::metric;
    depth.semantics = DepthSemantics::planar;
    depth.near_is_high = false;
    depth.code_max = 65535;
    depth.scale = metres / scene.metres_per_unit;
    depth.invalid_codes = {0, 65535};
    depth.invalid_code_count = 2;
    scene.depth_bits = 16;
    scene.hole_stiffness = Scene::soft_holes;
    int deepest = 0;
    for (const std::uint16_t code : codes)
        if (code != 65535) deepest = std::max<int>(deepest, code);
    if (deepest == 0) return input_error("no pixel of the picture has a depth: all are 0");
    constexpr double beyond = 1.05;  // of what is seen
    depth.far = std::min(beyond * deepest, 65534.0) * depth.scale;
    derive_valid_range(depth);
    TRY(validate(scene));
    RawFrame raw;
    raw.depth = plane_of_codes(codes.data(), width, height);
    DepthEstimator estimator(scene);
    estimator.add(raw);
    choose_filters(estimator.measured(), all_unstated, scene);
    TRY(validate(scene));
    clip = std::make_unique<Clip>(std::move(scene), 1, false);
    clip->begin(1, {}, {});
    set_plane(depth_role, width, height, 2, 1, codes);
    return {};
}

Result<void> take_plane(Role role, int bytes_per_sample, int channels, int size) {
    const Scene& scene = clip->scene();
    const int rows = scene.height * channels;
    const std::size_t count = pixel_count(scene.width, rows);
    const std::span<const std::uint8_t> packet(inbox.data(), static_cast<std::size_t>(size));
    const auto head = rank_head(packet, count);
    std::vector<std::uint16_t> samples(count);
    if (!head || !take_rank_content(*head, packet.subspan(head->bytes), scene.width, rows, samples.data(),
                                    scene.width))
        return input_error("the clip is damaged: a packet holds no picture of its size");
    set_plane(role, scene.width, scene.height, bytes_per_sample, channels, samples);
    return {};
}

}  // namespace

/// Memory for the bytes of the next call.
EXPORTED(room) std::uint8_t* page_room(std::size_t bytes) {
    inbox.resize(bytes);
    return inbox.data();
}
EXPORTED(fault) const char* page_fault() {
    return fault_text.c_str();
}
/// In `room`: the scene's numbers, and the frames' own times, ns, as doubles.
EXPORTED(open_scene) int page_open(int numbers, int times, double frames, int is_live) {
    return worked(open_scene(numbers, times, frames, is_live != 0));
}
/// In `room`: codes of 16 bits.
EXPORTED(open_picture) int page_open_one(int width, int height, double metres, double degrees) {
    return worked(open_picture(width, height, metres, degrees));
}
/// In `room`: a packet's head, and its content, inflated.
EXPORTED(plane) int page_plane(int role, int bytes_per_sample, int channels, int size) {
    return worked(take_plane(static_cast<Role>(role), bytes_per_sample, channels, size));
}
EXPORTED(wanted) double page_wanted() {
    return static_cast<double>(clip->wanted());
}
EXPORTED(give) int page_give() {
    return worked(clip->give());
}
/// In `room`: goals, 3 doubles each, finger by finger and tick by tick, and then commands, 4 doubles each.
EXPORTED(begin) void page_begin(int fingers, int goals, int commands) {
    const auto values = taken<double>(0, static_cast<std::size_t>(3 * goals + 4 * commands));
    std::vector<glm::dvec3> places;
    for (int k = 0; k < goals; ++k) places.emplace_back(values[3 * k], values[3 * k + 1], values[3 * k + 2]);
    std::vector<PlaybackCommand> playback;
    for (int k = 0; k < commands; ++k) {
        const double* const of = values.data() + 3 * goals + 4 * k;
        playback.push_back({static_cast<std::int64_t>(of[0]),
                            static_cast<PlaybackVerb>(static_cast<int>(of[1])),
                            static_cast<std::int64_t>(of[2]), static_cast<std::int64_t>(of[3])});
    }
    clip->begin(fingers, std::move(places), std::move(playback));
}
EXPORTED(run) int page_run(int ticks) {
    return clip->run(ticks);
}
EXPORTED(size) void page_size(int width, int height) {
    clip->set_size(width, height);
}
/// `kind`: InputEvent's; `button`: 0 none, 1 left, 2 right, 3 middle; `pen`: its pressure, 0 to 1.
EXPORTED(event)
void page_event(int kind, int button, double x, double y, int control, int shift, int touch, double seconds,
                double pen, int turns) {
    constexpr const char* buttons[] = {"", "left", "right", "middle"};
    InputEvent given{.kind = static_cast<InputEvent::Kind>(kind),
                     .x = x,
                     .y = y,
                     .word = buttons[button & 3],
                     .control = control != 0,
                     .shift = shift != 0,
                     .touch = touch,
                     .seconds = seconds};
    clip->event(given, pen, turns != 0);
}
EXPORTED(command) int page_command(int verb, double a, double b) {
    return worked(clip->command(static_cast<PageCommand>(verb), a, b));
}
EXPORTED(look) const void* page_look() {
    clip->look(shown, matrix.data());
    return &shown;
}
EXPORTED(view_matrix) const float* page_view_matrix() {
    return matrix.data();
}
EXPORTED(shown_number) double page_shown_number() {
    return static_cast<double>(clip->shown_number());
}
EXPORTED(drawn_depths) const float* page_drawn_depths() {
    return clip->drawn_depths().data();
}
/// The haptic picture of the frame that is drawn; null: it has none.
EXPORTED(drawn_haptic) const std::uint8_t* page_drawn_haptic() {
    const SurfaceFrame* const frame = clip->drawn_frame();
    return frame && !frame->haptic.empty() ? frame->haptic.data() : nullptr;
}
EXPORTED(drawn_heights) const std::uint16_t* page_drawn_heights() {
    const SurfaceFrame* const frame = clip->drawn_frame();
    return frame && !frame->heights.empty() ? frame->heights.data() : nullptr;
}
EXPORTED(sound) const float* page_sound() {
    return clip->samples().data();
}
EXPORTED(forget_sound) void page_forget_sound() {
    clip->samples().clear();
}
/// The forces' hash so far: 16 digits.
EXPORTED(hash) const char* page_hash() {
    hash_text = clip->hash();
    return hash_text.c_str();
}

}  // namespace touchable
