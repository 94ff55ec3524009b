// SPDX-License-Identifier: Apache-2.0
#pragma once

// Generated scenes, most of whose surfaces are known in closed form: globes, height fields, primitives, noise
// (docs/content.md).
//
// make_scene makes a scene by its name and SceneOptions; scene_names lists the names. An AnalyticScene
// returns frames as a recording of it would store them (frame: codes in the scene's depth coding, haptic and
// height planes, colour), and depth in closed form, against which tests and benchmarks measure. The same
// options give the same bits on every machine: random numbers come from a seed
// (engine/content/families.hpp), and sines from engine/base/same_bits.hpp.
//
// Threads: one at a time may request frames of a scene; it makes those of large pictures with more
// (SceneOptions::threads).

#include <glm/vec3.hpp>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

struct GlobeMaps;

enum class CameraPreset { a, a_prime, b };

/// Size, depth and look of a generated scene.
struct SceneOptions {
    int width = 720, height = 480;          ///< pixels; noise, cliffs and grain are 128x128 as published
    int bits = 16;                          ///< of the stored depth, 8 to 16
    CameraPreset preset = CameraPreset::b;  ///< globe only
    double tilt_degrees = 20;               ///< plane: angle between its normal and the optical axis, 0 to 60
    double tilt_direction_degrees = 0;      ///< plane: direction in which it recedes; 0 right, 90 up
    std::uint64_t seed = 1;                 ///< noise, cliffs, grain, and the planet of globe
    bool properties = false;                ///< globe: rotating planet with land and ocean, heights, friction
    const GlobeMaps* maps = nullptr;  ///< globe with properties: replaces the planet; read while it is made
    double seconds_per_turn = 12;     ///< globe with properties: above 0
    std::optional<double> axial_tilt_degrees{};       ///< the same: tilt of the pole, -90 to 90
    std::optional<double> first_longitude_degrees{};  ///< the same: facing the camera at time 0
    FrameRate rate{};                                 ///< frames come evenly
    int threads = 0;  ///< that share a frame's rows; 0: as many as pay, at most one per core. Same bits
};

/// A scene whose surface is known in closed form (docs/content.md). Everything is the same bits everywhere.
class AnalyticScene : NonCopyable {
public:
    /// The planes of one frame, row-major; colour and haptic interleaved by three. Empty: no such plane.
    struct Planes {
        std::vector<std::uint8_t> depth8;    ///< 8-bit codes
        std::vector<std::uint16_t> depth16;  ///< codes of 9 to 16 bits
        std::vector<std::uint8_t> colour, haptic, height;
    };

    virtual ~AnalyticScene() = default;
    const Scene& scene() const { return scene_; }
    /// Time of frame n in seconds: the scene's integer nanoseconds, divided once.
    double time_of(std::int64_t n) const { return static_cast<double>(scene_.rate.time_ns(n)) / 1e9; }

    /// Depth at pixel (x, y) at time t (seconds), of the scene's semantics, scene units, before height.
    virtual double depth(double x, double y, double t) const = 0;
    /// The same for a whole row of pixels.
    virtual void row_depths(int y, double t, double* depths) const {
        for (int x = 0; x < scene_.width; ++x) depths[x] = depth(x, y, t);
    }

    /// All planes of frame n, quantised.
    RawFrame frame(std::int64_t n) const;

protected:
    explicit AnalyticScene(Scene scene) : scene_(std::move(scene)) {}

private:
    /// Adds the colour, haptic and height planes that the scene has, at time t, for these depths.
    virtual void paint(double /*t*/, const std::vector<double>& /*depths*/, RowBands& /*rows*/,
                       Planes& /*planes*/) const {}
    /// False if every frame is the same picture.
    virtual bool moves() const { return false; }
    std::shared_ptr<const Planes> planes(double t) const;
    friend Result<std::unique_ptr<AnalyticScene>> make_scene(std::string_view, const SceneOptions&);

    Scene scene_;
    int threads_ = 0;                    // from SceneOptions
    mutable std::once_flag still_once_;  // a picture that never changes is made once
    mutable std::shared_ptr<const Planes> still_;
};

/// "globe", "bumps", "rough", "moving", "plane", "spheres", "step", "noise", "cliffs", "grain".
std::vector<std::string_view> scene_names();
/// Refuses an unknown name (listing the known) and impossible options.
Result<std::unique_ptr<AnalyticScene>> make_scene(std::string_view name, const SceneOptions& options);

}  // namespace touchable
