// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/noisy_scene.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

constexpr int blobs = 12;
constexpr double most_blob_radius = 5, silhouette = 50, flying_share = 0.3;

struct DepthPicture {
    int width, height;
    std::vector<double> depths;

    double at(int x, int y) const {
        return depths[static_cast<std::size_t>(std::clamp(y, 0, height - 1)) *
                          static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(std::clamp(x, 0, width - 1))];
    }
};

/// Nearest and farthest depth around a pixel.
std::pair<double, double> around(const DepthPicture& picture, int x, int y) {
    double nearest = picture.at(x, y), farthest = nearest;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            nearest = std::min(nearest, picture.at(x + dx, y + dy));
            farthest = std::max(farthest, picture.at(x + dx, y + dy));
        }
    return {nearest, farthest};
}

void cut_blobs(int width, int height, SplitMix64& random, std::vector<std::uint16_t>& codes) {
    for (int blob = 0; blob < blobs; ++blob) {
        const double cx = random.within(0, width), cy = random.within(0, height);
        const double radius = random.within(1, most_blob_radius);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if ((x - cx) * (x - cx) + (y - cy) * (y - cy) < radius * radius)
                    codes[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(x)] = 0;
    }
}

}  // namespace

std::vector<double> shared_noise(int width, int height, SplitMix64& random) {
    const auto pitch = static_cast<std::size_t>(width) + 1;
    std::vector<double> own(pitch * (static_cast<std::size_t>(height) + 1)), shared;
    for (double& value : own) value = normal(random);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
            const double* at = own.data() + y * pitch + x;
            shared.push_back(0.5 * (at[0] + at[1] + at[pitch] + at[pitch + 1]));
        }
    return shared;
}

Scene noisy_scene() {
    Scene scene;
    scene.name = "noisy";
    scene.width = 320;
    scene.height = 240;
    scene.camera = {285, 285, 159.5, 119.5};
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.near = 400;
    scene.depth.far = 2000;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    scene.default_properties = {600, 0.4, 0.3};
    scene.filter.median = 5;
    scene.filter.temporal_noise = {0.7, 1.2e-6};
    scene.device_metres_per_unit = 0.001;
    return scene;
}

double ball_and_wall(double x, double y, double t) {
    const double u = (x - 159.5) / 285, v = (y - 119.5) / 285;
    const double wall = 1200 / (1 - 0.2 * u - 0.1 * v);
    // |s (u, v, 1) - centre| = radius, the smaller s.
    constexpr double radius = 150;
    const double cx = 300 * sine(2 * pi * 0.3 * t), cz = 900 + 60 * sine(2 * pi * 0.5 * t);
    const double a = u * u + v * v + 1, b = u * cx + cz, c = cx * cx + cz * cz - radius * radius;
    const double root = b * b - a * c;
    return root > 0 ? std::min((b - std::sqrt(root)) / a, wall) : wall;
}

double normal(SplitMix64& random) {
    double sum = -6;
    for (int n = 0; n < 12; ++n) sum += random.unit();
    return sum;
}

double camera_noise(double depth) {
    const double beyond = depth / 1000 - 0.4;
    return 1.2 + 1.9 * beyond * beyond;
}

RawFrame noisy_frame(const Scene& scene, const TrueDepth& truth, std::int64_t number) {
    RawFrame raw;
    raw.number = number;
    raw.time_ns = scene.rate.time_ns(number);
    const double t = static_cast<double>(raw.time_ns) * 1e-9;
    SplitMix64 random(mix64(static_cast<std::uint64_t>(number) + 1));
    DepthPicture picture{scene.width, scene.height, {}};
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) picture.depths.push_back(truth(x, y, t));
    const std::vector<double> noise = shared_noise(scene.width, scene.height, random);
    auto codes = std::make_shared<std::vector<std::uint16_t>>();
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            double depth = picture.at(x, y) + camera_noise(picture.at(x, y)) * noise[codes->size()];
            const auto [nearest, farthest] = around(picture, x, y);
            if (farthest - nearest > silhouette && random.unit() < flying_share)
                depth = random.within(nearest, farthest);
            codes->push_back(static_cast<std::uint16_t>(std::floor(std::clamp(depth, 0.0, 65535.0) + 0.5)));
        }
    cut_blobs(scene.width, scene.height, random, *codes);
    // PlaneView holds bytes.
    raw.depth = {reinterpret_cast<const std::uint8_t*>(codes->data()),
                 std::ptrdiff_t{2} * scene.width,
                 scene.width,
                 scene.height,
                 2,
                 1};
    raw.storage = std::move(codes);
    return raw;
}

}  // namespace touchable
