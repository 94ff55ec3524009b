// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/content/globe_maps.hpp"
#include "engine/content/scenes.hpp"

namespace touchable::test {

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

/// A map that a test makes, with its own memory.
struct MadeMap {
    int width, height, channels, bytes;
    std::vector<std::uint8_t> samples;

    GlobeMap map() const {
        return {{samples.data(), static_cast<std::ptrdiff_t>(width) * channels * bytes, width, height, bytes,
                 channels},
                {},
                width,
                height,
                channels,
                bytes == 1 ? 255 : 65535};
    }
};

/// `value(longitude, latitude, channel)` in radians, of the middle of each pixel.
inline MadeMap made_map(int width, int channels, int bytes,
                        const std::function<double(double, double, int)>& value) {
    const double half_turn = 3.14159265358979323846;
    MadeMap made{width, width / 2, channels, bytes, {}};
    for (int y = 0; y < made.height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c) {
                const double number = value(((x + 0.5) / width - 0.5) * 2 * half_turn,
                                            (0.5 - (y + 0.5) / made.height) * half_turn, c);
                const auto code = static_cast<std::uint16_t>(number + 0.5);
                std::uint8_t stored[2];
                std::memcpy(stored, &code, 2);
                made.samples.insert(made.samples.end(), stored, stored + bytes);
            }
    return made;
}

/// The same grey everywhere.
inline MadeMap even_map(double value, int width = 64, int bytes = 1) {
    return made_map(width, 1, bytes, [=](double, double, int) { return value; });
}

/// A world of one continent, 1.4 radians wide around longitude 0, with two mountain ranges across it.
/// Elevation: 16 bits, 20000 is the sea; mask: `land` and `ocean`.
struct MadeWorld {
    static constexpr double sea_level = 20000;
    MadeMap colour, elevation, mask;
    GlobeMaps maps;

    static bool is_land(double longitude, double latitude) {
        return std::fabs(longitude) < 0.7 && std::fabs(latitude) < 0.6;
    }
    /// As the elevation map has it.
    static double height(double longitude, double latitude) {
        if (!is_land(longitude, latitude)) return 15000 + 2000 * std::cos(latitude);
        const double broad = std::exp(-20 * longitude * longitude),
                     narrow = std::exp(-800 * (latitude - 0.3) * (latitude - 0.3));
        return 20500 + 30000 * broad + 15000 * narrow;
    }
    explicit MadeWorld(int width = 360, double land = 255, double ocean = 0)
        : colour(made_map(width, 3, 1,
                          [](double longitude, double latitude, int c) {
                              const bool dry = is_land(longitude, latitude);
                              return dry ? (c == 0 ? 150.0 : 120.0) : (c == 2 ? 140.0 : 20.0);
                          })),
          elevation(
              made_map(width, 1, 2,
                       [](double longitude, double latitude, int) { return height(longitude, latitude); })),
          mask(made_map(width, 1, 1, [=](double longitude, double latitude, int) {
              return is_land(longitude, latitude) ? land : ocean;
          })) {
        maps.colour = colour.map();
        maps.elevation = elevation.map();
        maps.mask = mask.map();
        maps.shore = {sea_level, 65535, land > ocean, 0.5 * (land + ocean), 1};
    }
    MadeWorld(const MadeWorld&) = delete;
    MadeWorld& operator=(const MadeWorld&) = delete;
};

}  // namespace touchable::test
