#include "engine/scene/flying_pixels.hpp"

namespace touchable {

std::optional<FlyingPixels> flying_pixels(const Scene& scene) {
    if (scene.filter.flying_pixels == DepthLength{}) return std::nullopt;
    return FlyingPixels{code_curve(scene.depth, scene.filter.flying_pixels, 1)};
}

}  // namespace touchable
