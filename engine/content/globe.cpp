#include <cmath>
#include <glm/geometric.hpp>

#include "engine/content/families.hpp"
#include "engine/content/presets.hpp"

namespace touchable {
namespace {

/// The bare sphere before the far plane.
class Globe : public AnalyticScene {
public:
    Globe(Scene scene, const GlobeSphere& sphere) : AnalyticScene(std::move(scene)), sphere_(sphere) {}

    /// Range r = b - sqrt(b^2 - c) with b = ray . centre and c = |centre|^2 - R^2; the far plane beside the
    /// sphere.
    double depth(double x, double y, double /*t*/) const override {
        const double distance = -sphere_.centre.z;
        const double b = distance / scene().camera.ray_length(x, y);
        const double under_root = b * b - (distance * distance - sphere_.radius * sphere_.radius);
        return under_root > 0 ? b - std::sqrt(under_root) : scene().depth.far;
    }

    std::optional<SurfaceTruth> closest(const glm::dvec3& goal, const glm::dvec3& start,
                                        double /*t*/) const override {
        glm::dvec3 outward = goal - sphere_.centre;
        if (glm::dot(outward, outward) == 0) outward = start - sphere_.centre;
        if (glm::dot(outward, outward) == 0) outward = {0, 0, 1};
        outward /= std::sqrt(glm::dot(outward, outward));
        return SurfaceTruth{sphere_.centre + sphere_.radius * outward, outward};
    }

protected:
    GlobeSphere sphere_;
};

}  // namespace

MadeScene make_globe(std::string_view name, const SceneOptions& options) {
    Scene scene = blank_scene(name, options);
    apply_preset(options.preset, scene);
    const GlobeSphere sphere = globe_sphere(options.preset, options.width, options.height);
    if (-sphere.centre.z - sphere.radius < scene.depth.near)
        return usage_error("scene 'globe': a picture of " + std::to_string(options.width) + "x" +
                           std::to_string(options.height) +
                           " is too tall: a globe of 80 % of its height would reach before the near plane");
    scene.device_metres_per_unit = globe_device_radius / sphere.radius;
    scene.default_properties = {1000, 0, 0};
    return std::unique_ptr<AnalyticScene>(std::make_unique<Globe>(std::move(scene), sphere));
}

}  // namespace touchable
