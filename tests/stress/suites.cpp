// SPDX-License-Identifier: Apache-2.0
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Needs some_contact{};
constexpr Needs little_contact{0.02};

constexpr std::array<Suite, 25> all_suites{{
    {"uniform-noise", "every pixel for itself over the whole range", make_uniform_noise, some_contact},
    {"checkerboard", "cliffs from near to far, 1 to 3 pixels apart", make_checkerboard, some_contact},
    {"staircase", "ramps of single codes", make_staircase, some_contact},
    {"spike-and-pit", "single pixels out of and into a flat ground, crossed fast", make_spike_and_pit,
     some_contact},
    {"lattice-lines", "goals exactly along each kind of edge and through vertices, and 1 ulp beside",
     make_lattice_lines, little_contact},
    {"camera-axis", "goals on the axis, in the camera and behind it", make_camera_axis, little_contact},
    {"far-goals", "goals a million units away and farther", make_far_goals, little_contact},
    {"corner-jumps", "goals that jump between the corners of the frustum", make_corner_jumps, little_contact},
    {"tiny-pictures", "pictures of 1 and 2 pixels a side", make_tiny_pictures, little_contact},
    {"height-limit", "heights of which a thousandth of the nearest depth is left", make_height_limit,
     some_contact},
    {"impossible-planes",
     "planes that are equal, negative or swapped are refused; all but equal ones touched",
     make_impossible_planes,
     {0.05, false, true}},
    {"not-finite", "depths and goals that are no numbers", make_not_finite, {0.05, false, false, true}},
    {"rising", "a surface that rises past the finger by 1 to 255 levels a tick", make_rising, {0.05, true}},
    {"cut-every-frame", "every frame is another picture", make_cut_every_frame, {0.15, true}},
    {"late-frames",
     "frames that come late, not at all, or of another size",
     make_late_frames,
     {0.15, true, true}},
    {"far-million", "planes at 1 and 1e6", make_far_million, little_contact},
    {"wide-planes", "near down to a millionth of far, in units from tiny to huge", make_wide_planes,
     little_contact},
    {"camera-plane", "near down to a millionth of far, and goals of every length through the camera's plane",
     make_camera_plane, little_contact},
    {"plateau", "flat grounds, pyramids and valleys with goals as far from all sides", make_plateau,
     some_contact},
    {"press-slide-retract", "loops in, along and out, both ways", make_press_slide_retract, some_contact},
    {"stiffness-boundary", "loops over a border between 0.1 and 10 N/mm", make_stiffness_boundary,
     some_contact},
    {"encoder-dither", "a hand at rest whose encoders flicker by one count", make_encoder_dither,
     some_contact},
    {"five-fingers", "five fingers at one point", make_five_fingers, some_contact},
    {"stopped-producer",
     "frames that stop coming under a moving, then a resting hand",
     make_stopped_producer,
     {0.15, true}},
    {"jumping-walls",
     "walls and crests that jump under up to ten fingers, with friction, stiffness and goals that come and "
     "go",
     make_jumping_walls,
     {0.15, true}},
}};

}  // namespace

std::unique_ptr<StressRun> Suite::run(std::uint64_t seed) const {
    std::uint64_t drawn = seed;
    for (const char letter : name) drawn = mix64(drawn ^ static_cast<std::uint64_t>(letter));
    return make(drawn);
}

std::span<const Suite> suites() {
    return all_suites;
}

const Suite* find_suite(std::string_view name) {
    const auto found = std::find_if(all_suites.begin(), all_suites.end(),
                                    [&](const Suite& suite) { return suite.name == name; });
    return found == all_suites.end() ? nullptr : &*found;
}

namespace {

// Suites that are out for energy: loops that a passive surface pays nothing for, and hands that are almost at
// rest.

/// Depth at the pixel nearest to (x, y), of the coding's semantics; the far plane's where it is none.
double depth_under(const Scene& scene, const SurfaceFrame& frame, double x, double y) {
    const int i = std::clamp(static_cast<int>(std::floor(x + 0.5)), 0, scene.width - 1);
    const int j = std::clamp(static_cast<int>(std::floor(y + 0.5)), 0, scene.height - 1);
    const DepthSample sample = frame.vertices->at(i, j);
    return sample.valid ? sample.depth : scene.depth.far;
}

/// A hand that goes round closed loops of `loop_ticks` ticks: each comes back to where it began.
class LoopingHand : public StillRun {
public:
    LoopingHand(const Scene& scene, const DrawnPlanes& planes, SplitMix64 random)
        : StillRun(scene, planes), random_(random) {}

protected:
    static constexpr int loop_ticks = 400;
    /// Picks the corners of the next loop; four of them, in pixels and planar depth.
    virtual std::array<glm::dvec3, 4> corners() = 0;

    /// Planar depth of the surface under a pixel.
    double surface_depth(double x, double y) const {
        return planar_depth(scene_.camera, scene_.depth.semantics, x, y, depth_under(scene_, frame_, x, y));
    }
    SplitMix64 random_;

private:
    glm::dvec3 goal(std::int64_t tick) override {
        if (tick % loop_ticks == 0) begin_loop();
        return on_loop(static_cast<double>(tick % loop_ticks) / loop_ticks);
    }
    void begin_loop() {
        const auto at = corners();
        for (std::size_t k = 0; k < 4; ++k) corners_[k] = unproject(scene_.camera, at[k].x, at[k].y, at[k].z);
    }
    glm::dvec3 on_loop(double turn) const {
        const auto side = static_cast<std::size_t>(4 * turn);
        return corners_[side] +
               (corners_[(side + 1) % 4] - corners_[side]) * (4 * turn - static_cast<double>(side));
    }
    std::array<glm::dvec3, 4> corners_{};
};

/// Above, in, along, out: one way round or the other.
class PressSlideRetract final : public LoopingHand {
    using LoopingHand::LoopingHand;
    std::array<glm::dvec3, 4> corners() override {
        const double x = random_.within(1, scene_.width - 2), y = random_.within(1, scene_.height - 2);
        const double x1 = std::clamp(x + random_.within(-6, 6), 0.0, scene_.width - 1.0);
        const double y1 = std::clamp(y + random_.within(-6, 6), 0.0, scene_.height - 1.0);
        const double reach = 0.1 * (scene_.depth.far - scene_.depth.near);
        const double d = surface_depth(x, y), d1 = surface_depth(x1, y1);
        std::array<glm::dvec3, 4> loop{{{x, y, std::max(0.5 * d, d - reach)},
                                        {x, y, d + reach},
                                        {x1, y1, d1 + reach},
                                        {x1, y1, std::max(0.5 * d1, d1 - reach)}}};
        if (chance(random_, 0.5)) std::reverse(loop.begin(), loop.end());
        return loop;
    }
};

/// In on the soft side, over the border, out on the stiff one, or back.
class StiffnessBoundary final : public LoopingHand {
public:
    StiffnessBoundary(const Scene& scene, const DrawnPlanes& planes, SplitMix64 random)
        : LoopingHand(scene, planes, random) {
        guard_.rise.paid = chance(random_, 0.5);
    }
    std::string broken_promise(std::int64_t, std::span<const Contact> contacts,
                               std::span<const GuardedForce>) override {
        const Contact& contact = contacts[0];
        if (!contact.touching) return {};
        const double k = contact.properties.stiffness;
        if (!(k >= 100 * (1 - 1e-12) && k <= 10000 * (1 + 1e-12)))
            return "stiffness is not between both sides'";
        return {};
    }

private:
    std::array<glm::dvec3, 4> corners() override {
        const double middle = scene_.width / 2.0, y = random_.within(1, scene_.height - 2);
        const double soft = middle - random_.within(0.2, 4), stiff = middle + random_.within(0.2, 4);
        const double reach = random_.within(0.2, 1.0);
        const double d = surface_depth(soft, y), d1 = surface_depth(stiff, y);
        std::array<glm::dvec3, 4> loop{
            {{soft, y, d - reach}, {soft, y, d + reach}, {stiff, y, d1 + reach}, {stiff, y, d1 - reach}}};
        if (chance(random_, 0.5)) std::reverse(loop.begin(), loop.end());
        return loop;
    }
};

/// A hand that rests in the surface while its encoders flicker by one count (0.06 mm): the same flicker over
/// and over must not set anything swinging.
class EncoderDither final : public StillRun {
public:
    EncoderDither(const Scene& scene, const DrawnPlanes& planes, SplitMix64 random)
        : StillRun(scene, planes), random_(random) {
        guard_.max_force = 1e6;
        count_ = 0.00006 / touch_.metres_per_scene_unit;
    }
    std::string broken_promise(std::int64_t tick, std::span<const Contact> contacts,
                               std::span<const GuardedForce> forces) override {
        const std::int64_t at = tick % rest_ticks;
        auto& before = last_[static_cast<std::size_t>(tick % period)];
        std::string broken;
        // Friction lets a proxy creep, less and less, or take turns between orbits; but from the period on in
        // which it has settled it stays within a count of where that had it.
        if (at < 20 * period) {
            before = contacts[0].proxy;
        } else if (contacts[0].touching && !(forces[0].reasons & guard_ramp) && !contacts[0].counts.capped) {
            const glm::dvec3 moved = contacts[0].proxy - before;
            if (glm::dot(moved, moved) > count_ * count_)
                broken = "a hand at rest: the proxy has left the place where it had settled";
        }
        return broken;
    }

private:
    static constexpr int period = 8, rest_ticks = 400;
    glm::dvec3 goal(std::int64_t tick) override {
        if (tick % rest_ticks == 0) {
            settle();
            return glm::dvec3(0.0);  // it comes from in front; then it rests
        }
        return rest_ + count_ * pattern_[static_cast<std::size_t>(tick % period)];
    }
    void settle() {
        const double x = random_.within(0, scene_.width - 1), y = random_.within(0, scene_.height - 1);
        const double depth = depth_under(scene_, frame_, x, y);
        const double pressed = random_.within(0, 0.05) * (scene_.depth.far - scene_.depth.near);
        rest_ = unproject(scene_.camera, x, y,
                          planar_depth(scene_.camera, scene_.depth.semantics, x, y, depth + pressed));
        for (glm::dvec3& flicker : pattern_)
            flicker = {below(random_, 3) - 1, below(random_, 3) - 1, below(random_, 3) - 1};
    }
    SplitMix64 random_;
    double count_ = 0;
    glm::dvec3 rest_{0};
    std::array<glm::dvec3, period> pattern_{}, last_{};
};

template <class Run>
std::unique_ptr<StressRun> over_waves(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random);
    const DrawnPlanes planes = draw_waves(scene, random);
    return std::make_unique<Run>(scene, planes, random);
}

}  // namespace

std::unique_ptr<StressRun> make_press_slide_retract(std::uint64_t seed) {
    return over_waves<PressSlideRetract>(seed);
}

std::unique_ptr<StressRun> make_stiffness_boundary(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    set_planes(scene, DepthCodingKind::linear, 40, 180, 16);
    scene.height_coding.max_height = 0;
    scene.haptic = {{0.1, 10.0}, {0, 0}, {0, 0}};
    if (scene.hole_stiffness) scene.hole_stiffness = 0.5;  // between both sides'
    DrawnPlanes planes = draw_waves(scene, random);
    planes.haptic.clear();
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
            planes.haptic.insert(planes.haptic.end(),
                                 {static_cast<std::uint8_t>(x < scene.width / 2 ? 0 : 255), 0, 0});
    return std::make_unique<StiffnessBoundary>(scene, planes, random);
}

std::unique_ptr<StressRun> make_encoder_dither(std::uint64_t seed) {
    return over_waves<EncoderDither>(seed);
}

namespace {

// Suites that are out for the surface: pictures without mercy, touched by walks and by hands that feel their
// way.

/// One picture under one hand.
class HandRun final : public StillRun {
public:
    using Hand = std::variant<Walk, Skim>;
    template <class MakeHand>
    HandRun(const Scene& scene, const DrawnPlanes& planes, MakeHand make_hand)
        : StillRun(scene, planes), hand_(make_hand(scene_)) {}

private:
    glm::dvec3 goal(std::int64_t) override {
        if (Walk* walk = std::get_if<Walk>(&hand_)) return walk->next();
        return std::get<Skim>(hand_).next(frame_);
    }
    Hand hand_;
};

template <class MakeHand>
std::unique_ptr<StressRun> still(const Scene& scene, const DrawnPlanes& planes, MakeHand make_hand) {
    return std::make_unique<HandRun>(scene, planes, make_hand);
}

auto walking(std::uint64_t seed, const Walk::Reach& reach = {}) {
    return [=](const Scene& scene) -> HandRun::Hand { return Walk(scene, seed, reach); };
}
auto skimming(std::uint64_t seed, const Skim::Pace& pace = {}) {
    return [=](const Scene& scene) -> HandRun::Hand { return Skim(scene, seed, pace); };
}

}  // namespace

std::unique_ptr<StressRun> make_uniform_noise(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random, 96);
    const DrawnPlanes planes = draw_noise(scene, random);
    return still(scene, planes, walking(random.next()));
}

std::unique_ptr<StressRun> make_checkerboard(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random);
    const int side = 1 + below(random, 3);
    DrawnPlanes planes = shaped(scene, [&](int x, int y) {
        return (x / side + y / side) % 2 == 0 ? nearest_depth(scene) : scene.depth.far;
    });
    add_planes(scene, random, planes);
    return still(scene, planes, walking(random.next()));
}

std::unique_ptr<StressRun> make_staircase(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random);
    const double turn = random.within(0, 2 * pi), run = random.within(0.5, 6);  // pixels a code
    const int low = scene.depth.valid_min, high = scene.depth.valid_max;
    DrawnPlanes planes;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const double steps =
                ((x - scene.width / 2) * cosine(turn) + (y - scene.height / 2) * sine(turn)) / run;
            planes.codes.push_back(static_cast<std::uint16_t>(
                std::clamp((low + high) / 2 + static_cast<int>(std::floor(steps)), low, high)));
        }
    add_planes(scene, random, planes);
    const std::uint64_t walk = random.next();
    return still(scene, planes, skimming(walk, {random.within(0.02, 2.0)}));
}

std::unique_ptr<StressRun> make_spike_and_pit(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random, 32);
    std::array<std::array<int, 2>, 4> places;
    for (auto& place : places) place = {below(random, scene.width), below(random, scene.height)};
    const double middle = 0.5 * (nearest_depth(scene) + scene.depth.far);
    DrawnPlanes planes = shaped(scene, [&](int x, int y) {
        for (std::size_t k = 0; k < places.size(); ++k)
            if (places[k] == std::array{x, y}) return k % 2 == 0 ? nearest_depth(scene) : scene.depth.far;
        return middle;
    });
    add_planes(scene, random, planes);
    const std::uint64_t walk = random.next();
    return still(scene, planes, skimming(walk, {random.within(0.1, 5.0), random.within(0.01, 0.5)}));
}

std::unique_ptr<StressRun> make_far_million(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    scene.height_coding.max_height = 0;
    const auto kind = chance(random, 0.5) ? DepthCodingKind::linear : DepthCodingKind::inverse;
    set_planes(scene, kind, 1, 1e6, 16);
    const DrawnPlanes planes = draw_any(scene, random);
    return still(scene, planes, walking(random.next(), {1, 0.001}));
}

std::unique_ptr<StressRun> make_wide_planes(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    draw_wide_planes(random, scene);
    const DrawnPlanes planes = draw_any(scene, random);
    const std::uint64_t walk = random.next();
    return still(scene, planes, walking(walk, {1, chance(random, 0.5) ? 0.02 : 1e-6}));
}

std::unique_ptr<StressRun> make_tiny_pictures(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    scene.width = 1 + static_cast<int>(seed & 1);
    scene.height = 1 + static_cast<int>(seed >> 1 & 1);
    scene.camera = {random.within(1, 50), random.within(1, 50), random.within(-1, 2), random.within(-1, 2)};
    const DrawnPlanes planes = draw_noise(scene, random);
    return still(scene, planes, walking(random.next(), {0.3, 0.01, 0.01}));
}

namespace {

/// Whether the ground is a pyramid, a pit, a roof or a valley, or nothing: goals under the middle are as far
/// from all sides, and every choice is a tie.
class PlateauRun final : public StillRun {
public:
    PlateauRun(const Scene& scene, SplitMix64 random) : StillRun(scene), random_(random) {
        middle_ = scene_.width / 2;
        slope_ = below(random_, 5) - 2;
        const bool roof = chance(random_, 0.5);
        show(shaped(scene_, [&](int x, int y) {
            const int aside = std::abs(x - middle_), along = std::abs(y - middle_);
            return 128.0 - 8.0 * slope_ * (roof ? aside : std::max(aside, along));
        }));
    }

private:
    glm::dvec3 goal(std::int64_t tick) override {
        // From above the middle straight down, and now and then a whole pixel aside: exactly, in doubles.
        if (tick % 40 == 0) {
            x_ = middle_ + (chance(random_, 0.5) ? 0 : below(random_, 9) - 4);
            y_ = middle_ + (chance(random_, 0.5) ? 0 : below(random_, 9) - 4);
        }
        const double depth = 32.0 + 16.0 * static_cast<double>(tick % 40 < 20 ? tick % 40 : 39 - tick % 40);
        return unproject(scene_.camera, x_, y_, depth);
    }

    SplitMix64 random_;
    int middle_, slope_;
    double x_ = 0, y_ = 0;
};

}  // namespace

std::unique_ptr<StressRun> make_plateau(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = whole_unit_scene(17, 32, 512);
    if (!chance(random, 0.7)) scene.depth.semantics = DepthSemantics::range;
    if (chance(random, 0.4)) scene.default_properties = {1000, 0.5, 0.5};
    return std::make_unique<PlateauRun>(scene, random);
}

namespace {

// Suites that are out for the input: heights up to the camera, planes that cannot be, numbers that are none.

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

/// Whether the scene is refused with these planes.
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
    // The extreme that is allowed: planes that all but touch.
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
        const std::array<double, 5> odd{nan, 1e300, 1.0000001 * largest_goal(scene_), inf, -inf};
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
