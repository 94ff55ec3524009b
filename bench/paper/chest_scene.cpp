// SPDX-License-Identifier: Apache-2.0
#include "bench/paper/chest_scene.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bench/touch/noisy_scene.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/content/families.hpp"

namespace touchable {
namespace {

constexpr double focal_length = 4.7, pixel_width = 0.0112;            // mm; a sensor 3.6 mm wide
constexpr double near_plane = 40, far_plane = 180;                    // cm
constexpr double wall_depth = 170, chest_front = 100;                 // cm
constexpr double half_width = 20, half_height = 35, half_depth = 12;  // cm, of the ellipsoid
constexpr double device_width = 0.16;  // m; width of the picture for the hand, at the chest

}  // namespace

Scene chest_scene() {
    Scene scene;
    scene.name = "chest";
    scene.width = 320;
    scene.height = 240;
    scene.metres_per_unit = 0.01;
    scene.camera = camera_from_focal_length(focal_length, pixel_width, scene.width, scene.height);
    scene.depth_bits = 8;
    scene.depth.near = near_plane;
    scene.depth.far = far_plane;
    derive_valid_range(scene.depth);
    scene.default_properties = {600, 0.4, 0.3};  // the same in the whole scene, as in the paper
    scene.device_metres_per_unit = device_width / (scene.width / scene.camera.fx * chest_front);
    return scene;
}

double chest_range(const Camera& camera, double x, double y) {
    // |(s u / half_width, s v / half_height, (centre - s) / half_depth)| = 1, the smaller s.
    const double u = camera.u(x), v = camera.v(y), centre = chest_front + half_depth;
    const double a = u * u / (half_width * half_width) + v * v / (half_height * half_height) +
                     1 / (half_depth * half_depth);
    const double b = centre / (half_depth * half_depth), c = centre * centre / (half_depth * half_depth) - 1;
    const double root = b * b - a * c;
    const double planar = root > 0 ? std::min((b - std::sqrt(root)) / a, wall_depth) : wall_depth;
    return planar * camera.ray_length(x, y);
}

RawFrame noisy_chest_frame(const Scene& scene, double noise_levels, std::int64_t number) {
    SplitMix64 random(mix64(static_cast<std::uint64_t>(number) + 1));
    const double deviation = noise_levels * scene.depth.level();
    std::vector<double> ranges;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
            ranges.push_back(chest_range(scene.camera, x, y) + deviation * normal(random));
    auto planes = std::make_shared<AnalyticScene::Planes>();
    RowBands rows(1);
    quantise(scene, ranges, rows, *planes);
    return view_of(std::move(planes), scene, number);
}

}  // namespace touchable
