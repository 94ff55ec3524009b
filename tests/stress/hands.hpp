#pragma once

#include <glm/vec3.hpp>

#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"

/// Where the goals of the stress suites come from.
namespace touchable::stress {

/// Anywhere in the picture's frustum and a little beyond, on and off the surface, in steps and jumps.
class Walk {
public:
    struct Reach {
        double pixels = 1;        ///< a tick, at most, in x and in y
        double depth = 0.02;      ///< a tick, at most, of the distance between the planes
        double jumps = 1.0 / 50;  ///< share of ticks in which it jumps anywhere
    };
    Walk(const Scene& scene, std::uint64_t seed) : Walk(scene, seed, Reach{}) {}
    Walk(const Scene& scene, std::uint64_t seed, const Reach& reach);
    glm::dvec3 next();

private:
    void jump();
    Camera camera_;
    glm::dvec3 low_, high_;  // of column, row, planar depth
    glm::dvec3 reach_;
    double jumps_;
    SplitMix64 random_;
    glm::dvec3 at_{0};
};

/// Over the surface on a winding path, in and out of it: what a hand does that feels its way.
class Skim {
public:
    struct Pace {
        double pixels = 0.5;  ///< a tick
        double under = 0.04;  ///< how deep it presses, of the distance between the planes
        double period = 400;  ///< ticks from one time out of the surface to the next
    };
    Skim(const Scene& scene, std::uint64_t seed) : Skim(scene, seed, Pace{}) {}
    Skim(const Scene& scene, std::uint64_t seed, const Pace& pace);
    /// `frame`: what is under the hand now; over an invalid pixel it keeps its depth.
    glm::dvec3 next(const SurfaceFrame& frame);

private:
    const Scene& scene_;
    Pace pace_;
    SplitMix64 random_;
    double x_, y_, heading_, depth_;
    std::int64_t tick_ = 0;
};

}  // namespace touchable::stress
