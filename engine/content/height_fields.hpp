#pragma once

// The height fields' surfaces, and the goal paths that tests and benchmarks share (docs/content.md): one goal
// per tick of 1 ms, world, scene units.

#include <cstdint>
#include <glm/vec3.hpp>

#include "engine/content/families.hpp"
#include "engine/content/seeded_noise.hpp"

namespace touchable {

/// The three height fields: Z = -1000 + 1000 b(X/1000, Y/1000, t) in scene units (millimetres).
enum class Relief { bumps, rough, moving };

/// Surface over a world position: Z (scene units) and its first and second derivatives by X and Y (per unit).
struct ReliefPoint {
    double z, zx, zy, zxx, zxy, zyy;
};
ReliefPoint relief_at(Relief relief, double x, double y, double t);
/// Z alone.
double relief_z(Relief relief, double x, double y, double t);

/// The accuracy stroke: a straight approach along the first normal, then 1 mm of device space under the
/// globe.
class GlobeStroke {
public:
    static constexpr int approach_ticks = 200, stroke_ticks = 20000;

    /// For the globe without properties at this size.
    GlobeStroke(CameraPreset preset, int width, int height)
        : sphere_(globe_sphere(preset, width, height)),
          units_per_metre_(sphere_.radius / globe_device_radius) {}

    struct Goal {
        glm::dvec3 goal;
        glm::dvec3 normal;   ///< of the sphere under which the goal lies: the true direction of the force
        double polar_angle;  ///< of that normal from the axis to the camera, radians, at most 58.1 degrees
    };
    /// 0 <= tick < approach_ticks + stroke_ticks.
    Goal at(int tick) const;

private:
    GlobeSphere sphere_;
    double units_per_metre_;  // scene units per metre of device space
};

/// The stroke over a height field: constant lateral speed on a winding path, reflected 12 mm from the
/// picture's edges (at depth 1000), under the surface by 3.5 mm + 1.5 sin(2 pi 0.9 t) once the first 0.25 s
/// have brought it down from 50 mm above.
class ReliefStroke {
public:
    /// Speed in m/s (device and scene are one to one); the picture's height must leave more than 24 mm of
    /// surface.
    ReliefStroke(Relief relief, int width, int height, double speed);

    struct Goal {
        glm::dvec3 goal;
        double under;  ///< depth under the surface along Z, scene units; negative: above it
    };
    /// Returns the goals of ticks 0, 1, 2, ... in turn.
    Goal next();

private:
    void advance();

    Relief relief_;
    double limit_x_, limit_y_;  // the path stays within +-limit
    double step_;               // scene units per tick
    std::int64_t tick_ = 0;
    double x_ = 0, y_ = 0, heading_ = 0.3;
};

/// A goal path for the stress scenes: each tick moves by up to 1 pixel in x and y and 3 units of planar
/// depth, and every 50th tick on average jumps anywhere. It leaves the picture by up to 2 pixels, and the
/// depths of the scene a little.
class RandomWalk {
public:
    RandomWalk(const Scene& scene, std::uint64_t seed);
    glm::dvec3 next();

private:
    void jump() {
        for (int axis = 0; axis < 3; ++axis) at_[axis] = random_.within(low_[axis], high_[axis]);
    }

    Camera camera_;
    glm::dvec3 low_, high_;  // of column, row, planar depth
    SplitMix64 random_;
    glm::dvec3 at_;
};

}  // namespace touchable
