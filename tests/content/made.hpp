#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string_view>

#include "engine/content/scenes.hpp"
#include "engine/content/seeded_noise.hpp"

namespace touchable {

/// The scene, or a failed test that says why there is none.
inline std::unique_ptr<AnalyticScene> made(std::string_view name, const SceneOptions& options = {}) {
    auto scene = make_scene(name, options);
    if (!scene) {
        ADD_FAILURE() << scene.error().message;
        return nullptr;
    }
    return std::move(*scene);
}

inline SceneOptions sized(int width, int height, int bits = 16) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.bits = bits;
    return options;
}

/// World point that the scene shows at a pixel.
inline glm::dvec3 seen(const AnalyticScene& scene, double x, double y, double t) {
    const Scene& s = scene.scene();
    return unproject(s.camera, x, y, planar_depth(s.camera, s.depth.semantics, x, y, scene.depth(x, y, t)));
}

inline double length(const glm::dvec3& a) {
    return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
}

}  // namespace touchable
