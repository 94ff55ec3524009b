// SPDX-License-Identifier: Apache-2.0
// Suites that are out for the goal: along lattice lines to the bit, behind the camera, very far away,
// everywhere at once.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "engine/run/touch_run.hpp"
#include "tests/stress/drawn_scene.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {
namespace {

class GoalRun : public StillRun {
public:
    GoalRun(const Scene& scene, const DrawnPlanes& planes, std::uint64_t seed)
        : StillRun(scene, planes), random_(seed) {}

protected:
    SplitMix64 random_;
};

/// Goals whose pixel and planar depth are exact in doubles: focal lengths and depths are powers of two, so
/// that the way lies on lattice lines to the bit.
class LatticeLines final : public GoalRun {
public:
    using GoalRun::GoalRun;

private:
    glm::dvec3 goal(std::int64_t tick) override {
        if (tick % 64 == 0) start();
        const double step = static_cast<double>(tick % 64) / 8.0;  // stops on every vertex
        static constexpr std::array<std::array<int, 2>, 3> directions{{{1, 0}, {0, 1}, {1, 1}}};
        const auto& [dx, dy] = directions[direction_];
        glm::dvec3 at = unproject(scene_.camera, column_ + dx * step, row_ + dy * step, depth_);
        if (tick % 64 == 0) at = unproject(scene_.camera, column_, row_, 16);  // in front of all there is
        at.x = nudged(at.x);
        at.y = nudged(at.y);
        return at;
    }
    void start() {
        direction_ = static_cast<std::size_t>(below(random_, 3));
        column_ = below(random_, 10) - 1;
        row_ = below(random_, 10) - 1;
        depth_ = 32 << below(random_, 4);
        for (int& ulp : ulps_) ulp = below(random_, 3) - 1;
        next_ = 0;
    }
    double nudged(double value) {
        const int ulp = ulps_[next_++ % 2];
        return ulp == 0 ? value : std::nextafter(value, ulp * std::numeric_limits<double>::infinity());
    }

    std::size_t direction_ = 0, next_ = 0;
    double column_ = 0, row_ = 0, depth_ = 32;
    std::array<int, 2> ulps_{};
};

/// On the axis and beside it by next to nothing, before the camera, in it and behind it.
class CameraAxis final : public GoalRun {
public:
    using GoalRun::GoalRun;

private:
    glm::dvec3 goal(std::int64_t) override {
        const double far = scene_.depth.far;
        glm::dvec3 at{0, 0, -random_.within(0, 1.2 * far)};
        switch (below(random_, 6)) {
            case 0:
                at.z = random_.within(-1, 1);
                break;
            case 1:
                at.z = chance(random_, 0.5) ? 0.0 : 1e-12 * random_.within(-1, 1);
                break;
            case 2:
                at.z = random_.within(0, far);
                break;
            default:
                break;
        }
        if (chance(random_, 0.3)) {
            at.x = random_.within(-1, 1) * (chance(random_, 0.5) ? 1e-9 : 0.1 * far);
            at.y = random_.within(-1, 1) * (chance(random_, 0.5) ? 1e-9 : 0.1 * far);
        }
        return at;
    }
};

/// A walk with excursions to where nothing is.
class FarGoals final : public GoalRun {
public:
    FarGoals(const Scene& scene, const DrawnPlanes& planes, std::uint64_t seed)
        : GoalRun(scene, planes, seed), walk_(scene_, seed + 1) {}

private:
    glm::dvec3 goal(std::int64_t) override {
        if (chance(random_, 0.9)) return walk_.next();
        const double reach = chance(random_, 0.5) ? 1e6 : 0.9 * largest_goal(scene_);
        return {random_.within(-reach, reach), random_.within(-reach, reach), random_.within(-reach, reach)};
    }
    Walk walk_;
};

class CornerJumps final : public GoalRun {
public:
    using GoalRun::GoalRun;

private:
    glm::dvec3 goal(std::int64_t) override {
        const double x = chance(random_, 0.5) ? -0.7 : scene_.width - 0.3;
        const double y = chance(random_, 0.5) ? -0.7 : scene_.height - 0.3;
        const std::array depths{0.5 * scene_.depth.near, scene_.depth.near,
                                0.5 * (scene_.depth.near + scene_.depth.far), scene_.depth.far,
                                1.5 * scene_.depth.far};
        const double depth = depths[static_cast<std::size_t>(below(random_, depths.size()))];
        return unproject(scene_.camera, x, y, std::max(depth, 0.01 * scene_.depth.far));
    }
};

/// Anything from a rounding to the largest goal there is, sideways, before the camera and behind it.
class CameraPlane final : public GoalRun {
public:
    using GoalRun::GoalRun;

private:
    glm::dvec3 goal(std::int64_t) override {
        const double far = scene_.depth.far;
        // Every other one where the picture is.
        if (chance(random_, 0.5)) {
            const double x = random_.within(-1, scene_.width), y = random_.within(-1, scene_.height);
            return unproject(scene_.camera, x, y, magnitude(random_, 1e-12 * far, 12));
        }
        return {any(), any(), any()};
    }
    double any() {
        const double length = chance(random_, 0.1) ? 0.0 : magnitude(random_, 1e-13 * scene_.depth.far, 19);
        return chance(random_, 0.5) ? length : -length;
    }
};

class FiveFingers final : public GoalRun {
public:
    FiveFingers(const Scene& scene, const DrawnPlanes& planes, std::uint64_t seed)
        : GoalRun(scene, planes, seed), walk_(scene_, seed + 1) {}
    std::size_t fingers() const override { return 5; }
    std::string broken_promise(std::int64_t, std::span<const Contact> contacts,
                               std::span<const GuardedForce> forces) override {
        for (std::size_t k = 1; k < contacts.size(); ++k)
            if (contacts[k].proxy != contacts[0].proxy || forces[k].force != forces[0].force)
                return "fingers 0 and " + std::to_string(k) + " have the same goals and not the same forces";
        return {};
    }

private:
    glm::dvec3 goal(std::int64_t) override { return walk_.next(); }
    Walk walk_;
};

template <class Run>
std::unique_ptr<StressRun> over_drawn(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random);
    const DrawnPlanes planes = draw_any(scene, random);
    return std::make_unique<Run>(scene, planes, random.next());
}

}  // namespace

std::unique_ptr<StressRun> make_lattice_lines(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = whole_unit_scene(9, 32, 256);
    if (chance(random, 0.3)) scene.default_properties = {1000, 0.4, 0.25};
    DrawnPlanes planes;
    const bool flat = chance(random, 0.3);
    for (int k = 0; k < scene.width * scene.height; ++k)
        planes.codes.push_back(static_cast<std::uint16_t>(flat ? 64 : 32 << below(random, 4)));
    return std::make_unique<LatticeLines>(scene, planes, random.next());
}

std::unique_ptr<StressRun> make_camera_axis(std::uint64_t seed) {
    return over_drawn<CameraAxis>(seed);
}
std::unique_ptr<StressRun> make_far_goals(std::uint64_t seed) {
    return over_drawn<FarGoals>(seed);
}
std::unique_ptr<StressRun> make_corner_jumps(std::uint64_t seed) {
    return over_drawn<CornerJumps>(seed);
}
std::unique_ptr<StressRun> make_camera_plane(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    draw_wide_planes(random, scene);
    const DrawnPlanes planes = draw_any(scene, random);
    return std::make_unique<CameraPlane>(scene, planes, random.next());
}
std::unique_ptr<StressRun> make_five_fingers(std::uint64_t seed) {
    return over_drawn<FiveFingers>(seed);
}

namespace {

// Suites that are out for time: surfaces that rise past the finger, cuts, frames that do not come as they
// should.

/// A loop of frames, `ticks_per_frame` apart, over and over; frame numbers and times go on.
class LoopRun final : public StressRun {
public:
    LoopRun(const Scene& scene, const std::vector<DrawnPlanes>& pictures, int ticks_per_frame,
            std::uint64_t seed, const Walk::Reach& reach)
        : StressRun(scene),
          frames_(pictures.size()),
          ticks_per_frame_(ticks_per_frame),
          walk_(scene_, seed, reach) {
        FrameMaker maker(scene_);
        for (std::size_t k = 0; k < pictures.size(); ++k) maker.build(pictures[k], frames_[k]);
    }
    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        pair.prev = frame(tick / ticks_per_frame_);
        pair.next = frame(tick / ticks_per_frame_ + 1);
        pair.blend = static_cast<double>(tick % ticks_per_frame_) / ticks_per_frame_;
        goals[0] = walk_.next();
    }

private:
    TimedFrame frame(std::int64_t number) const {
        return {number, number * ticks_per_frame_ * tick_ns,
                &frames_[static_cast<std::size_t>(number) % frames_.size()]};
    }
    std::vector<SurfaceFrame> frames_;
    int ticks_per_frame_;
    Walk walk_;
};

}  // namespace

std::unique_ptr<StressRun> make_rising(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random, 24);
    scene.filter = {};
    const int levels = 1 << below(random, 8);  // a tick: 1 to 128 of 255, and all of it below
    const double rise = chance(random, 0.2) ? 1.0 : levels / 255.0;
    const double near = nearest_depth(scene), far = scene.depth.far;
    std::vector<DrawnPlanes> pictures;
    const int steps = std::clamp(static_cast<int>(std::ceil(1 / rise)), 1, 48);
    for (int k = 0; k <= steps; ++k) {
        const double share = std::min(1.0, k * rise);
        DrawnPlanes planes = shaped(scene, [&](int x, int y) {
            return std::max(near, far - (far - near) * share * (1 - 0.1 * ((x + 2 * y) % 3)));
        });
        add_planes(scene, random, planes);
        pictures.push_back(std::move(planes));
    }
    return std::make_unique<LoopRun>(scene, pictures, 1, random.next(), Walk::Reach{0.3, 0.005, 0.005});
}

std::unique_ptr<StressRun> make_cut_every_frame(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random, 32);
    std::vector<DrawnPlanes> pictures;
    for (int k = 0; k < 12; ++k) pictures.push_back(draw_any(scene, random));
    const int ticks = 1 + below(random, 33);
    return std::make_unique<LoopRun>(scene, pictures, ticks, random.next(), Walk::Reach{0.5, 0.01, 0.01});
}

namespace {

/// Frames through a SurfaceTimeline.
class LiveRun : public StressRun {
protected:
    LiveRun(const Scene& scene, const SplitMix64& random)
        : StressRun(scene), maker_(scene_), random_(random) {}
    /// Draws a picture where there is room for one.
    template <class Draw>
    void publish(std::int64_t tick, Draw draw) {
        SurfaceFrame* slot = timeline_.acquire();
        if (!slot || tick * tick_ns <= timeline_.newest_time()) return;
        maker_.build(draw(), *slot);
        (void)timeline_.publish(published_++, tick * tick_ns);
    }

    FrameMaker maker_;
    SurfaceTimeline timeline_{4};
    SplitMix64 random_;

private:
    std::int64_t published_ = 0;
};

/// As live: frames come late, in bursts or not at all, some of another size.
class LateFrames final : public LiveRun {
public:
    LateFrames(const Scene& scene, SplitMix64 random) : LiveRun(scene, random), walk_(scene_, random.next()) {
        for (int k = 0; k < 8; ++k) pictures_.push_back(draw_waves(scene_, random_));
        publish_any(0);
    }

    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        // The frame of a moment is ready up to 20 ms after it; one in six never comes.
        if (tick % 33 == 0 && !chance(random_, 1.0 / 6)) due_ = tick + below(random_, 20);
        if (tick == due_) publish_any(tick / 33 * 33 + 33);
        if (chance(random_, 0.01)) offer_another_size();
        timeline_.pair_at(tick * tick_ns, pair);
        goals[0] = walk_.next();
    }
    int refusals() const override { return refusals_; }

private:
    void publish_any(std::int64_t tick) {
        publish(tick, [&] { return pictures_[static_cast<std::size_t>(below(random_, 8))]; });
    }
    void offer_another_size() {
        SurfaceFrame* slot = timeline_.acquire();
        if (slot && !maker_.build(pictures_[0], scene_.width + 1, scene_.height - 1, *slot)) ++refusals_;
    }

    Walk walk_;
    std::vector<DrawnPlanes> pictures_;
    std::int64_t due_ = -1;
    int refusals_ = 0;
};

/// A producer that stops; the surface then stands still, and under a goal that rests so do the forces.
class StoppedProducer final : public LiveRun {
public:
    StoppedProducer(const Scene& scene, SplitMix64 random)
        : LiveRun(scene, random), hand_(scene_, random.next()) {
        stops_ = 100 + below(random_, 200);
        publish_waves(0);
    }

    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        if (tick < stops_ && tick % 33 == 0) publish_waves(tick + 33);
        timeline_.pair_at(tick * tick_ns, pair);
        stands_ = pair.next.frame == pair.prev.frame;
        // It feels its way, and rests every now and then.
        if (tick % 200 < 120) goal_ = hand_.next(*pair.prev.frame);
        goals[0] = goal_;
    }

    std::string broken_promise(std::int64_t tick, std::span<const Contact> contacts,
                               std::span<const GuardedForce> forces) override {
        const std::int64_t at = tick % 200;
        std::string broken;
        if (tick > stops_ + 66 && !stands_) broken = "the producer has stopped and the surface moves";
        // The first tick at rest may still slide on, as far as friction then lets it.
        if (stands_ && stood_ && at > 121 && !contacts[0].counts.capped &&
            forces[0].reasons == last_.reasons &&
            !(forces[0].reasons & (guard_ramp | guard_jump | guard_rise)) &&
            differs(forces[0].force, last_.force))
            broken = "nothing moves and the force changes";
        last_ = forces[0];
        stood_ = stands_;
        return broken;
    }

private:
    /// A force that goes on improving by roundings is no change.
    static bool differs(const glm::dvec3& a, const glm::dvec3& b) {
        for (int axis = 0; axis < 3; ++axis)
            if (std::fabs(a[axis] - b[axis]) > 1e-9 * (1 + std::fabs(a[axis]))) return true;
        return false;
    }
    void publish_waves(std::int64_t tick) {
        publish(tick, [&] { return draw_waves(scene_, random_); });
    }

    Skim hand_;
    std::int64_t stops_ = 0;
    glm::dvec3 goal_{0};
    bool stands_ = false, stood_ = false;
    GuardedForce last_;
};

/// Held pictures of walls, tents and waves that jump by up to 25 mm, under fingers that move as hands do.
class JumpingWalls final : public StressRun {
public:
    JumpingWalls(const Scene& scene, SplitMix64 random) : StressRun(scene), random_(random), frames_(6) {
        FrameMaker maker(scene_);
        const double turn = random_.within(0, 2 * pi), length = random_.within(3, 12),
                     height = chance(random_, 0.3) ? 0 : random_.within(2, 30);
        const bool is_tent = chance(random_, 0.6), has_map = chance(random_, 0.3);
        for (SurfaceFrame& frame : frames_) {
            const double wall = 600 + random_.within(-12, 12),
                         shift = chance(random_, 0.3) ? random_.unit() : 0;
            DrawnPlanes planes = shaped(scene_, [&](int x, int y) {
                const double along = (x * cosine(turn) + y * sine(turn)) / length + shift;
                const double tent = 4 * std::fabs(along - std::floor(along + 0.5)) - 1;
                return wall + height * (is_tent ? tent : sine(2 * pi * along));
            });
            if (has_map)
                for (std::size_t k = 0; k < planes.codes.size(); ++k)
                    planes.haptic.insert(planes.haptic.end(), {static_cast<std::uint8_t>(below(random_, 256)),
                                                               static_cast<std::uint8_t>(128), 40});
            maker.build(planes, frame);
        }
        fingers_.resize(1 + static_cast<std::size_t>(below(random_, 10)));
        for (Finger& finger : fingers_) {
            finger.middle = {random_.within(-100, 100), random_.within(-100, 100),
                             random_.within(-620, -595)};
            for (Sway& sway : finger.sways)
                for (int axis = 0; axis < 3; ++axis) {
                    sway.period[axis] = random_.within(100, 1500);
                    sway.phase[axis] = random_.within(0, 2 * pi);
                    // Up to 0.3 m/s, and not far in depth.
                    sway.reach[axis] = std::min(axis == 2 ? 10.0 : 80.0,
                                                random_.within(0, 0.3) * sway.period[axis] / (2 * pi));
                }
        }
        guard_.waits_to_be_free = chance(random_, 0.3);
        if (chance(random_, 0.2)) guard_.max_stiffness = random_.within(200, 800);
    }
    std::size_t fingers() const override { return fingers_.size(); }

    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        if (tick == next_jump_) {
            next_jump_ += 5 + below(random_, 150);
            pair_.prev = pair_.next = {++number_, tick * tick_ns,
                                       &frames_[static_cast<std::size_t>(below(random_, 6))]};
            if (chance(random_, 0.3)) ++pair_.epoch;
        }
        pair = pair_;
        if (tick >= missing_until_ && chance(random_, 0.002)) missing_until_ = tick + 1 + below(random_, 60);
        for (std::size_t k = 0; k < goals.size(); ++k) goals[k] = fingers_[k].at(static_cast<double>(tick));
        if (tick < missing_until_) goals[0].x = std::numeric_limits<double>::quiet_NaN();
    }

private:
    struct Sway {
        glm::dvec3 period, phase, reach;
    };
    struct Finger {
        glm::dvec3 middle{0};
        std::array<Sway, 2> sways{};
        glm::dvec3 at(double tick) const {
            glm::dvec3 at = middle;
            for (const Sway& sway : sways)
                for (int axis = 0; axis < 3; ++axis)
                    at[axis] += sway.reach[axis] * sine(2 * pi * tick / sway.period[axis] + sway.phase[axis]);
            return at;
        }
    };

    SplitMix64 random_;
    std::vector<SurfaceFrame> frames_;
    std::vector<Finger> fingers_;
    FramePair pair_{};
    std::int64_t number_ = 0, next_jump_ = 0, missing_until_ = 0;
};

template <class Run>
std::unique_ptr<StressRun> live(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random, 32);
    return std::make_unique<Run>(scene, random);
}

}  // namespace

std::unique_ptr<StressRun> make_late_frames(std::uint64_t seed) {
    return live<LateFrames>(seed);
}
std::unique_ptr<StressRun> make_stopped_producer(std::uint64_t seed) {
    return live<StoppedProducer>(seed);
}
std::unique_ptr<StressRun> make_jumping_walls(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene;
    scene.width = scene.height = 24;
    scene.camera = {random.within(20, 80), random.within(20, 80), random.within(6, 18), random.within(6, 18)};
    scene.depth.semantics = DepthSemantics::planar;
    set_planes(scene, DepthCodingKind::linear, 500, 700, 16);
    scene.interpolation = FrameInterpolation::hold;
    scene.device_metres_per_unit = 0.001;
    const double friction = chance(random, 0.7) ? random.within(0.1, 1) : 0;
    scene.default_properties = {random.within(150, 1200), friction, friction * random.within(0.1, 1)};
    scene.haptic = {{0.1, random.within(0.2, 2)}, {0, 1}, {0, 1}};
    return std::make_unique<JumpingWalls>(scene, random);
}

}  // namespace touchable::stress
