// SPDX-License-Identifier: Apache-2.0
#pragma once

// The makers behind make_scene, one for each family of scenes, and their shared helpers: cameras, planes made
// of depths; the height fields' surface, the planet's ground and the noise it is made of. Callers have
// checked sizes and bits; each maker refuses what its own surface cannot be.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string_view>

#include "engine/base/threads.hpp"
#include "engine/content/scenes.hpp"

namespace touchable {

/// The globe's sphere: on the optical axis, filling 80 % of the picture's height. Scene units.
struct GlobeSphere {
    glm::dvec3 centre;
    double radius;
};

using MadeScene = Result<std::unique_ptr<AnalyticScene>>;

/// An error of kind usage that names the scene.
Error refuse_scene(std::string_view name, const std::string& what);

MadeScene make_globe(std::string_view name, const SceneOptions& options);
MadeScene make_height_field(std::string_view name, const SceneOptions& options);
MadeScene make_primitive(std::string_view name, const SceneOptions& options);
MadeScene make_noise(std::string_view name, const SceneOptions& options);

/// Starting scene of every family: name, size, bits, code_max; camera and planes are still to be set.
Scene blank_scene(std::string_view name, const SceneOptions& options);

/// Number of threads for so many pixels: `threads` (SceneOptions) if above 0, otherwise as many as pay.
int threads_for_pixels(int threads, std::int64_t pixels);

/// The camera of the height fields and primitives: 200 mm wide at 1000 mm, metres_per_unit 0.001, device one
/// to one; planar linear coding between `near` and `far`; 600 N/m, friction 0.6 and 0.4. Width at least 2.
Scene tabletop_scene(std::string_view name, const SceneOptions& options, double near, double far);
inline constexpr double tabletop_distance = 1000, tabletop_width = 200;

/// Camera and range coding of a preset (docs/content.md) at a size: the pixel width scales by 720/W, so the
/// horizontal field of view stays.
void apply_preset(CameraPreset preset, Scene& scene);

GlobeSphere globe_sphere(CameraPreset preset, int width, int height);

/// The device radius of the globe, in metres: S = globe_device_radius / radius.
inline constexpr double globe_device_radius = 0.032;

/// Writes each depth's nearest code as the scene's plane of 8 or 16 bits.
void quantise(const Scene& scene, const std::vector<double>& depths, RowBands& rows,
              AnalyticScene::Planes& planes);

/// Returns a frame that shows the planes and keeps them alive.
RawFrame view_of(std::shared_ptr<const AnalyticScene::Planes> planes, const Scene& scene,
                 std::int64_t number);

/// The three height fields: Z = -1000 + 1000 b(X/1000, Y/1000, t) in scene units (millimetres).
enum class Relief { bumps, rough, moving };

/// Height at a world position over `base`, which `lift` raises with time; scene units; and its first and
/// second derivatives by X and Y (per unit).
struct ReliefPoint {
    double z, zx, zy, zxx, zxy, zyy;
};
ReliefPoint relief_at(Relief relief, double x, double y, double base);
double lift(Relief relief, double t);

/// The ground at one place of the procedural planet.
struct Ground {
    double elevation;  ///< over the sea: about -1 to 1, land where positive
    double relief;     ///< 0 (sea, coast) to 1 (highest mountain)
    double moisture;   ///< 0 (desert) to 1 (forest)
    double ice;        ///< 0 to 1: polar and mountain snow, sea ice
};

/// Smooth seeded noise in space: 0 at lattice points, about -0.8 to 0.8 between, two continuous derivatives,
/// a period of 256 per axis. The same bits on every machine.
class GradientNoise {
public:
    explicit GradientNoise(std::uint64_t seed);

    double at(const glm::dvec3& p) const;
    /// Sum of `count` octaves, each about twice as fine and half as strong as the one before.
    double octaves(glm::dvec3 p, int count) const;
    /// The same with sharp crests where an octave crosses zero; each finer octave grows on the crests of the
    /// coarser ones. 0 to about 1.
    double ridges(glm::dvec3 p, int count) const;

private:
    double corner(int x, int y, int z, const glm::dvec3& offset) const;
    std::array<std::uint8_t, 512> permutation_;
};

/// A deterministic imaginary planet: continents, mountains and climate from seeded noise. 38 % of it is land.
class Planet {
public:
    explicit Planet(std::uint64_t seed);
    /// `place`: unit vector in the planet's own frame, +Y its north pole.
    Ground ground(const glm::dvec3& place) const;

private:
    double continents(const glm::dvec3& place) const;

    GradientNoise noise_;
    double sea_level_;
};

}  // namespace touchable
