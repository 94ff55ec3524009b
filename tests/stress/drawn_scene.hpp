// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"

/// Scenes, pictures and goals drawn at random: the same from the same seed on every machine.
namespace touchable::stress {

inline int below(SplitMix64& random, int n) {
    return static_cast<int>(random.next() % static_cast<std::uint64_t>(n));
}
/// `least` times a number with up to so many digits more, evenly in the digits.
double magnitude(SplitMix64& random, double least, int digits);
inline bool chance(SplitMix64& random, double share) {
    return random.unit() < share;
}

/// A valid scene: any size up to `most_pixels` a side, any camera from tele to wide angle, on or off its
/// axis, any coding but hue; with or without friction, heights, a haptic image's ranges, invalid codes and
/// filters.
Scene draw_scene(SplitMix64& random, int most_pixels = 72);
/// The same scene with planes as far apart as a scene may have them: near down to a millionth of far, far
/// from 1e-3 to 1e12 units.
void draw_wide_planes(SplitMix64& random, Scene& scene);
/// A small square picture of planar depths, a unit a code, without friction. Focal length `side` - 1 and the
/// axis through the middle pixel: where that is a power of two, places on lattice lines are exact in doubles.
Scene whole_unit_scene(int side, double near, double far);
/// No depth that can be coded is smaller.
double nearest_depth(const Scene& scene);
/// A depth coding between two planes, of `bits`; metric codings get a scale of their own.
void set_planes(Scene& scene, DepthCodingKind kind, double near, double far, int bits);

/// The planes of a picture before they are built into a frame; codes as stored.
struct DrawnPlanes {
    std::vector<std::uint16_t> codes, heights;
    std::vector<std::uint8_t> haptic;
};
/// A code that stands for a depth, from all that do.
std::uint16_t draw_code(const Scene& scene, SplitMix64& random);
/// Codes of function(x, y) in scene units (the coding's own semantics), nearest to it.
template <class Function>
DrawnPlanes shaped(const Scene& scene, Function depth) {
    DrawnPlanes planes;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) planes.codes.push_back(scene.depth.code(depth(x, y)));
    return planes;
}
/// Adds what the scene can have: random heights and properties, and blobs of invalid pixels.
void add_planes(const Scene& scene, SplitMix64& random, DrawnPlanes& planes);
/// Every pixel for itself, and all that `add_planes` adds.
DrawnPlanes draw_noise(const Scene& scene, SplitMix64& random);
/// A few broad waves within the middle of the depth range, and all that `add_planes` adds.
DrawnPlanes draw_waves(const Scene& scene, SplitMix64& random);
/// The one or the other.
DrawnPlanes draw_any(const Scene& scene, SplitMix64& random);

/// Builds frames as the program does.
class FrameMaker {
public:
    explicit FrameMaker(const Scene& scene) : scene_(scene), builder_(make_cpu_builder(scene)) {}
    /// Refused where the planes are not of the scene's size.
    Result<void> build(const DrawnPlanes& planes, int width, int height, SurfaceFrame& out);
    void build(const DrawnPlanes& planes, SurfaceFrame& out);

private:
    const Scene& scene_;
    std::unique_ptr<SurfaceBuilder> builder_;
};

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
