// SPDX-License-Identifier: Apache-2.0
// Height fields, primitives and noise.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/same_bits.hpp"
#include "engine/base/words.hpp"
#include "engine/content/families.hpp"

namespace touchable {
namespace {

// ---- Height fields

/// amplitude sin(2 pi (kx x + ky y)/period + phase); lengths in scene units (millimetres).
struct Wave {
    double amplitude, period, kx, ky, phase;
};
using Waves = std::array<Wave, 4>;

constexpr Waves bumps{{{5, 100, 1, 0, 0}, {4, 80, 0, 1, 0.7}, {0.8, 30, 1, 1, 1.3}, {0.015, 6, 1, -2, 0.2}}};
constexpr Waves rough{{{4, 60, 1, 0, 0}, {3, 45, 0, 1, 0.7}, {1.5, 20, 1, 1, 1.3}, {0.4, 7, 1, -2, 0.2}}};

const Waves& waves_of(Relief relief) {
    return relief == Relief::rough ? rough : bumps;
}

double angle(const Wave& wave, double x, double y) {
    return 2 * pi * (wave.kx * x + wave.ky * y) / wave.period + wave.phase;
}

class HeightFieldScene final : public AnalyticScene {
public:
    HeightFieldScene(Scene scene, Relief relief) : AnalyticScene(std::move(scene)), relief_(relief) {}

    /// d = 1000 - b(d u, d v): the left side less the right grows with d as long as |slope| |(u, v)| < 1, so
    /// there is one root and Newton finds it.
    double depth(double x, double y, double t) const override {
        const double u = scene().camera.u(x), v = scene().camera.v(y),
                     base = tabletop_distance - lift(relief_, t);
        double d = base;
        for (int round = 0; round < 32; ++round) {
            const ReliefPoint at = relief_at(relief_, d * u, d * v, 0);
            const double step = (d - base + at.z) / (1 + u * at.zx + v * at.zy);
            d -= step;
            if (std::fabs(step) <= 1e-12) break;
        }
        return d;
    }

private:
    bool moves() const override { return relief_ == Relief::moving; }
    Relief relief_;
};

// ---- Primitives

/// A plane through the optical axis at 1000.
class PlaneScene final : public AnalyticScene {
public:
    PlaneScene(Scene scene, const glm::dvec3& normal) : AnalyticScene(std::move(scene)), normal_(normal) {}

    double depth(double x, double y, double /*t*/) const override {
        const double u = scene().camera.u(x), v = scene().camera.v(y);
        return tabletop_distance * normal_.z / (normal_.z - normal_.x * u - normal_.y * v);
    }

private:
    glm::dvec3 normal_;
};

/// Two balls in front of a wall, one partly in front of the other.
class SpheresScene final : public AnalyticScene {
public:
    explicit SpheresScene(Scene scene) : AnalyticScene(std::move(scene)) {}

    double depth(double x, double y, double /*t*/) const override {
        const glm::dvec3 ray{scene().camera.u(x), scene().camera.v(y), -1};
        double nearest = wall;
        for (const Ball& ball : balls) {
            const double a = glm::dot(ray, ray), b = glm::dot(ray, ball.centre);
            const double c = glm::dot(ball.centre, ball.centre) - ball.radius * ball.radius;
            const double under_root = b * b - a * c;
            if (under_root > 0) nearest = std::min(nearest, (b - std::sqrt(under_root)) / a);
        }
        return nearest;
    }

private:
    struct Ball {
        glm::dvec3 centre;
        double radius;
    };
    static constexpr double wall = 1080;
    const std::array<Ball, 2> balls{Ball{{-22, 4, -1020}, 45}, Ball{{35, -10, -960}, 30}};
};

/// Upright bands of the picture, flat and facing the camera, each 1, 2, ... 10 levels nearer than its left
/// neighbour; between two bands lies the sheet of rays that separates two columns. Across the picture it is a
/// polyline in (X, planar depth), the same at every Y.
class StepScene final : public AnalyticScene {
public:
    static constexpr int bands = 11, lowest_level = 100;

    explicit StepScene(Scene scene) : AnalyticScene(std::move(scene)) {}

    double depth(double x, double /*y*/, double /*t*/) const override {
        const double band = std::floor((x + 0.5) * bands / scene().width);
        return band_depth(static_cast<int>(std::clamp(band, 0.0, bands - 1.0)));
    }

private:
    double band_depth(int band) const {
        return scene().depth.far - scene().depth.level() * (lowest_level + band * (band + 1) / 2);
    }
};

MadeScene make_plane(std::string_view name, const SceneOptions& options) {
    if (!(options.tilt_degrees >= 0 && options.tilt_degrees <= 60))
        return refuse_scene(name, "tilt " + std::to_string(options.tilt_degrees) +
                                      " is impossible; it must be 0 to 60 degrees");
    if (!(std::fabs(options.tilt_direction_degrees) <= 360))
        return refuse_scene(name, "tilt direction " + std::to_string(options.tilt_direction_degrees) +
                                      " is impossible; it must be -360 to 360 degrees");
    const double tilt = options.tilt_degrees * pi / 180,
                 direction = options.tilt_direction_degrees * pi / 180;
    const glm::dvec3 normal{sine(tilt) * cosine(direction), sine(tilt) * sine(direction), cosine(tilt)};
    Scene scene = tabletop_scene(name, options, 750, 1350);
    auto plane = std::make_unique<PlaneScene>(scene, normal);
    for (const double x : {0.0, options.width - 1.0})
        for (const double y : {0.0, options.height - 1.0}) {
            const double depth = plane->depth(x, y, 0);
            if (!(depth >= scene.depth.near && depth <= scene.depth.far))
                return refuse_scene(
                    name, "a picture of " + size_text(options.width, options.height) +
                              " is too tall for this tilt: the plane would leave depths 750 to 1350");
        }
    return plane;
}

// ---- Noise

enum class NoiseKind { noise, cliffs, grain };

/// Pixels that are independent of their neighbours, for stress: there is no true surface, only a mesh.
class NoiseScene final : public AnalyticScene {
public:
    NoiseScene(Scene scene, NoiseKind kind, std::uint64_t seed)
        : AnalyticScene(std::move(scene)), kind_(kind), seed_(seed) {}

    /// Depth of the nearest pixel; for noise, cliffs and grain of 8 bits always the depth of a code.
    double depth(double x, double y, double /*t*/) const override {
        const auto column =
            static_cast<std::uint64_t>(std::clamp(std::floor(x + 0.5), 0.0, scene().width - 1.0));
        const auto row =
            static_cast<std::uint64_t>(std::clamp(std::floor(y + 0.5), 0.0, scene().height - 1.0));
        const std::uint64_t bits = mix64(mix64(seed_) ^ mix64(row << 32 | column)) >> 32;
        const DepthCoding& coding = scene().depth;
        if (kind_ == NoiseKind::cliffs) return bits & 1 ? coding.near : coding.far;
        if (kind_ == NoiseKind::grain)
            return coding.far - coding.level() * (128 + static_cast<double>(bits * 5 >> 32) - 2);
        return coding.depth(static_cast<std::uint16_t>(bits * (coding.code_max + std::uint64_t{1}) >> 32));
    }

private:
    NoiseKind kind_;
    std::uint64_t seed_;
};

}  // namespace

double lift(Relief relief, double t) {
    return relief == Relief::moving ? 20 * sine(2 * pi * 0.5 * t) : 0;
}

ReliefPoint relief_at(Relief relief, double x, double y, double base) {
    ReliefPoint sum{base, 0, 0, 0, 0, 0};
    for (const Wave& wave : waves_of(relief)) {
        const double phi = angle(wave, x, y), k = 2 * pi / wave.period, s = sine(phi);
        const double slope = wave.amplitude * k * cosine(phi), bend = -wave.amplitude * k * k * s;
        sum.z += wave.amplitude * s;
        sum.zx += slope * wave.kx;
        sum.zy += slope * wave.ky;
        sum.zxx += bend * wave.kx * wave.kx;
        sum.zxy += bend * wave.kx * wave.ky;
        sum.zyy += bend * wave.ky * wave.ky;
    }
    return sum;
}

MadeScene make_height_field(std::string_view name, const SceneOptions& options) {
    // The steepest slope is 1.6 along Y: in a picture more than four times as high as wide, a ray could meet
    // the surface twice.
    if (options.height > 4 * options.width)
        return refuse_scene(name, "a picture of " + size_text(options.width, options.height) +
                                      " is too tall; its height must be at most 4 widths");
    const Relief relief = name == "rough" ? Relief::rough : name == "moving" ? Relief::moving : Relief::bumps;
    const double reach = relief == Relief::moving ? 40 : 20;
    Scene scene = tabletop_scene(name, options, tabletop_distance - reach, tabletop_distance + reach);
    return std::make_unique<HeightFieldScene>(std::move(scene), relief);
}

MadeScene make_primitive(std::string_view name, const SceneOptions& options) {
    if (name == "plane") return make_plane(name, options);
    if (name == "spheres") return std::make_unique<SpheresScene>(tabletop_scene(name, options, 900, 1100));
    if (options.width < 2 * StepScene::bands)
        return refuse_scene(name, "width " + std::to_string(options.width) +
                                      " is too small; 11 bands need at least 22 pixels");
    return std::make_unique<StepScene>(tabletop_scene(name, options, 980, 1020));
}

MadeScene make_noise(std::string_view name, const SceneOptions& options) {
    Scene scene = blank_scene(name, options);
    apply_preset(CameraPreset::b, scene);
    scene.device_metres_per_unit = 0.001;
    scene.default_properties = {600, 0.6, 0.4};
    const NoiseKind kind = name == "noise"    ? NoiseKind::noise
                           : name == "cliffs" ? NoiseKind::cliffs
                                              : NoiseKind::grain;
    return std::make_unique<NoiseScene>(std::move(scene), kind, options.seed);
}

}  // namespace touchable
