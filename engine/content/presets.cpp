#include "engine/content/presets.hpp"

#include <cmath>

namespace touchable {
namespace {

struct Preset {
    double focal_length, pixel_width;  // at 720 pixels
    double near, far;
    double globe_distance;
};

constexpr Preset numbers(CameraPreset preset) {
    switch (preset) {
        case CameraPreset::a:
            return {6.983, 0.00123, 10, 200, 105};
        case CameraPreset::a_prime:
            return {6.983, 0.0123, 10, 200, 105};
        case CameraPreset::b:
            break;
    }
    return {4.7, 0.0112, 40, 180, 110};
}

double pixel_width(const Preset& preset, int width) {
    return preset.pixel_width * 720.0 / width;
}

}  // namespace

void apply_preset(CameraPreset preset, Scene& scene) {
    const Preset p = numbers(preset);
    scene.camera =
        camera_from_focal_length(p.focal_length, pixel_width(p, scene.width), scene.width, scene.height);
    scene.depth.kind = DepthCodingKind::linear;
    scene.depth.semantics = DepthSemantics::range;
    scene.depth.near_is_high = true;
    scene.depth.near = p.near;
    scene.depth.far = p.far;
    derive_valid_range(scene.depth);
}

GlobeSphere globe_sphere(CameraPreset preset, int width, int height) {
    const Preset p = numbers(preset);
    // R = D sin(atan(h)), h = 0.8 tan(VFOV/2) = 0.8 (H/2) / fy; sin(atan(h)) = h / sqrt(1 + h^2).
    const double h = 0.8 * (0.5 * height) * pixel_width(p, width) / p.focal_length;
    return {{0, 0, -p.globe_distance}, p.globe_distance * (h / std::sqrt(1.0 + h * h))};
}

}  // namespace touchable
