// Suites that are out for the surface: pictures without mercy, touched by walks and by hands that feel their
// way.
#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "engine/base/same_bits.hpp"
#include "tests/stress/hands.hpp"
#include "tests/stress/still_run.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {

namespace {

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
    const bool noise = chance(random, 0.5);
    const DrawnPlanes planes = noise ? draw_noise(scene, random) : draw_waves(scene, random);
    return still(scene, planes, walking(random.next(), {1, 0.001}));
}

std::unique_ptr<StressRun> make_wide_planes(std::uint64_t seed) {
    SplitMix64 random(seed);
    Scene scene = draw_scene(random);
    draw_wide_planes(random, scene);
    const DrawnPlanes planes = chance(random, 0.5) ? draw_noise(scene, random) : draw_waves(scene, random);
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

}  // namespace touchable::stress
