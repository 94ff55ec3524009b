#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/frame/raw_frame.hpp"
#include "engine/frame/surface_frame.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

enum class CameraPreset { a, a_prime, b };

/// Size, depth and look of a generated scene.
struct SceneOptions {
    int width = 720, height = 480;
    int bits = 16;  ///< of the stored depth, 8 to 16
    CameraPreset preset = CameraPreset::b;  ///< globe only
    double tilt_degrees = 20;               ///< plane: tilt away from the viewer, 0 to 60
    double tilt_direction_degrees = 0;      ///< plane: direction of the tilt in the picture
    std::uint64_t seed = 1;                 ///< noise and cliffs
    bool properties = false;  ///< globe: rotating planet with land and ocean, heights, friction
};

/// The analytic surface's nearest point to a goal under it, and the outward normal there.
struct SurfaceTruth {
    glm::dvec3 point, normal;
};

/// A scene whose surface is known in closed form (docs/scenes.md). Everything is the same bits everywhere.
class AnalyticScene {
public:
    virtual ~AnalyticScene() = default;
    virtual const Scene& scene() const = 0;
    /// Depth at pixel (x, y) at time t (seconds), of the scene's semantics, scene units, before height.
    virtual double depth(double x, double y, double t) const = 0;
    /// Nearest surface point to `goal`, searched by descent from `start` (a point on or near the surface).
    virtual SurfaceTruth closest(const glm::dvec3& goal, const glm::dvec3& start, double t) const = 0;
    /// All planes of frame n, quantised.
    virtual RawFrame frame(std::int64_t n) const = 0;
    /// Frame n with unquantised depth, for the solver (`vertices` is an ExactVertices).
    void exact_frame(std::int64_t n, SurfaceFrame& out) const;
};

/// "globe", "bumps", "rough", "moving", "plane", "spheres", "step", "noise", "cliffs".
const std::vector<std::string_view>& scene_names();
/// Refuses an unknown name (listing the known) and impossible options.
Result<std::unique_ptr<AnalyticScene>> make_scene(std::string_view name, const SceneOptions& options);

}  // namespace touchable
