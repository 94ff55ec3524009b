#include <algorithm>
#include <cmath>
#include <string>

#include "engine/content/families.hpp"
#include "engine/content/presets.hpp"
#include "engine/content/random.hpp"

namespace touchable {
namespace {

enum class NoiseKind { noise, cliffs, grain };

/// Pixels that know nothing of their neighbours, for stress: there is no surface to be near to, only a mesh.
class NoiseScene final : public AnalyticScene {
public:
    NoiseScene(Scene scene, NoiseKind kind, std::uint64_t seed)
        : AnalyticScene(std::move(scene)), kind_(kind), seed_(seed) {}

    /// Depth of the nearest pixel of the picture; always one that a code stands for where the kind is noise
    /// or cliffs, or grain of 8 bits.
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

    std::optional<SurfaceTruth> closest(const glm::dvec3&, const glm::dvec3&, double) const override {
        return {};
    }

private:
    NoiseKind kind_;
    std::uint64_t seed_;
};

}  // namespace

MadeScene make_noise(std::string_view name, const SceneOptions& options) {
    Scene scene = blank_scene(name, options);
    apply_preset(CameraPreset::b, scene);
    scene.device_metres_per_unit = 0.001;
    scene.default_properties = {600, 0.6, 0.4};
    const NoiseKind kind = name == "noise"    ? NoiseKind::noise
                           : name == "cliffs" ? NoiseKind::cliffs
                                              : NoiseKind::grain;
    return std::unique_ptr<AnalyticScene>(std::make_unique<NoiseScene>(std::move(scene), kind, options.seed));
}

}  // namespace touchable
