#pragma once

// The makers behind make_scene, one for each family of scenes, and their shared helpers: cameras, planes made
// of depths. Callers have checked sizes and bits; each maker refuses what its own surface cannot be.

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

}  // namespace touchable
