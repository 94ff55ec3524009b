// Suites that are out for the input: heights up to the camera, planes that cannot be, numbers that are none.
#include <array>
#include <cmath>
#include <limits>

#include "tests/stress/hands.hpp"
#include "tests/stress/still_run.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {

namespace {

/// A walk over one picture of a scene that is only just possible; neighbours of it were refused.
class JustPossible final : public StillRun {
public:
    JustPossible(const Scene& scene, const DrawnPlanes& planes, std::uint64_t seed, int refusals)
        : StillRun(scene, planes), walk_(scene_, seed), refusals_(refusals) {}
    int refusals() const override { return refusals_; }

private:
    glm::dvec3 goal(std::int64_t) override { return walk_.next(); }
    Walk walk_;
    int refusals_;
};

/// What becomes of a scene with other planes.
bool is_refused(Scene scene, double near, double far) {
    scene.depth.near = near;
    scene.depth.far = far;
    derive_valid_range(scene.depth);
    return !validate(scene);
}

}  // namespace

std::unique_ptr<StressRun> make_height_limit(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random, 40);
    scene.filter = {};
    scene.height_coding.units = HeightUnits::world;
    scene.height_coding.code_max = 255;
    // The largest height that is not refused, to the last bit: there the nearest depth all but vanishes.
    double possible = 0, impossible = scene.depth.far;
    while (true) {
        const double middle = possible + 0.5 * (impossible - possible);
        if (middle <= possible || middle >= impossible) break;
        scene.height_coding.max_height = middle;
        (validate(scene) ? possible : impossible) = middle;
    }
    const std::array<double, 4> short_of{1, 1 - 1e-12, 1 - 1e-6, 0.99};
    scene.height_coding.max_height = possible * short_of[static_cast<std::size_t>(below(random, 4))];
    const DrawnPlanes planes = draw_noise(scene, random);
    return std::make_unique<JustPossible>(scene, planes, random.next(), 1);
}

std::unique_ptr<StressRun> make_impossible_planes(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    scene.height_coding.max_height = 0;
    set_planes(scene, chance(random, 0.5) ? DepthCodingKind::linear : DepthCodingKind::inverse, 40, 180, 16);
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    const std::array<std::array<double, 2>, 9> impossible{{{100, 100},
                                                           {180, 40},
                                                           {-40, 180},
                                                           {40, -180},
                                                           {0, 180},
                                                           {nan, 180},
                                                           {40, nan},
                                                           {40, inf},
                                                           {-180, -40}}};
    int refusals = 0;
    for (const auto& [near, far] : impossible) refusals += is_refused(scene, near, far);
    if (refusals < static_cast<int>(impossible.size()))
        refusals = 0;  // one got through: nothing to be proud of
    // What can just be: planes that all but touch.
    const double gap = chance(random, 0.5) ? 1e-9 : 1e-3;
    set_planes(scene, scene.depth.kind, 100, 100 * (1 + gap), 16);
    const DrawnPlanes planes = draw_noise(scene, random);
    return std::make_unique<JustPossible>(scene, planes, random.next(), refusals);
}

namespace {

/// Unquantised depths with NaN and infinity among them, under a hand whose device breaks now and then.
class NotFinite final : public StillRun {
public:
    NotFinite(const Scene& scene, std::uint64_t seed)
        : StillRun(scene), random_(seed), walk_(scene_, seed + 1) {
        guard_.ramp_in_ticks = guard_.ramp_out_ticks = 20;
        const double nan = std::numeric_limits<double>::quiet_NaN(),
                     inf = std::numeric_limits<double>::infinity();
        std::vector<double> depths;
        for (int k = 0; k < scene_.width * scene_.height; ++k) {
            const std::array odd{nan, inf, -inf};
            depths.push_back(chance(random_, 0.1) ? odd[static_cast<std::size_t>(below(random_, 3))]
                                                  : random_.within(nearest_depth(scene_), scene_.depth.far));
        }
        frame_.width = scene_.width;
        frame_.height = scene_.height;
        frame_.coding = scene_.depth;
        frame_.vertices = std::make_unique<ExactVertices>(scene_.width, scene_.height, std::move(depths));
    }

    std::string broken_promise(std::int64_t, std::span<const Contact> contacts,
                               std::span<const GuardedForce> forces) override {
        const glm::dvec3& f = forces[0].force;
        const double length2 = f.x * f.x + f.y * f.y + f.z * f.z;
        std::string broken;
        if (contacts[0].goal_held && !(forces[0].reasons & guard_fault))
            broken = "a goal was held without a fault";
        if (contacts[0].goal_held && !(length2 <= last_length2_))
            broken = "the force grows while the goal is none";
        last_length2_ = length2;
        return broken;
    }

private:
    glm::dvec3 goal(std::int64_t tick) override {
        glm::dvec3 at = walk_.next();
        if (tick % 100 == 0) broken_ = chance(random_, 0.3) ? 1 + below(random_, 60) : 0;
        if (broken_-- <= 0) return at;
        const std::array<double, 5> odd{
            std::numeric_limits<double>::quiet_NaN(), 1e300, 1.0000001 * largest_goal(scene_),
            std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        at[below(random_, 3)] = odd[static_cast<std::size_t>(below(random_, 5))];
        return at;
    }
    SplitMix64 random_;
    Walk walk_;
    int broken_ = 0;
    double last_length2_ = 0;
};

}  // namespace

std::unique_ptr<StressRun> make_not_finite(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    scene.height_coding.max_height = 0;
    if (scene.depth.kind == DepthCodingKind::metric) set_planes(scene, DepthCodingKind::linear, 40, 180, 16);
    return std::make_unique<NotFinite>(scene, random.next());
}

}  // namespace touchable::stress
