// Suites that are out for the goal: along lattice lines to the bit, behind the camera, very far away,
// everywhere at once.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "tests/stress/hands.hpp"
#include "tests/stress/still_run.hpp"
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
    const DrawnPlanes planes = chance(random, 0.5) ? draw_noise(scene, random) : draw_waves(scene, random);
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
    const DrawnPlanes planes = chance(random, 0.5) ? draw_noise(scene, random) : draw_waves(scene, random);
    return std::make_unique<CameraPlane>(scene, planes, random.next());
}
std::unique_ptr<StressRun> make_five_fingers(std::uint64_t seed) {
    return over_drawn<FiveFingers>(seed);
}

}  // namespace touchable::stress
