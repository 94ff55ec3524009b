// Suites that are out for energy: loops that a passive surface pays nothing for, and hands that are almost at
// rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "tests/stress/still_run.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {

namespace {

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

}  // namespace

std::unique_ptr<StressRun> make_press_slide_retract(std::uint64_t seed) {
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random);
    const DrawnPlanes planes = draw_waves(scene, random);
    return std::make_unique<PressSlideRetract>(scene, planes, random);
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
    SplitMix64 random(seed);
    const Scene scene = draw_scene(random);
    const DrawnPlanes planes = draw_waves(scene, random);
    return std::make_unique<EncoderDither>(scene, planes, random);
}

}  // namespace touchable::stress
