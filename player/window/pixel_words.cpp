#include "player/window/pixel_words.hpp"

#include <cmath>

#include "engine/base/number_words.hpp"
#include "engine/scene/stored_code.hpp"

namespace touchable {
std::string metres_in_words(double depth, const Scene& scene) {
    return formatted("%.4f m", depth * scene.metres_per_unit);
}

std::string stored_in_words(const PlaneView& depth, const Scene& scene, int x, int y) {
    if (depth.empty()) return "";
    const std::uint16_t code = stored_code(depth, scene.depth, x, y);
    if (code == no_hue && scene.depth.kind == DepthCodingKind::hue) return "no hue";
    return "code " + std::to_string(code) + (scene.depth.is_valid(code) ? "" : ", no depth");
}

std::string length_in_words(double length, const Scene& scene) {
    const double metres = length * scene.metres_per_unit;
    if (metres >= 10) return formatted("%.3f m", metres);
    return formatted(metres < 0.1 ? "%.2f mm" : "%.1f mm", 1000 * metres);
}

std::string pressed_in_words(double millimetres) {
    return formatted("%.1f %s", std::abs(millimetres), millimetres < 0 ? "above" : "in");
}

}  // namespace touchable
