// SPDX-License-Identifier: Apache-2.0
#include "bench/real/depth_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace touchable {
namespace {

constexpr double least_depth = 1;  // mm in front of the camera; nearer surfaces are not drawn

/// A projected vertex; q = 1 / depth is linear over a flat triangle's picture.
struct SeenVertex {
    double x = 0, y = 0, q = 0;
};

void draw(const std::array<SeenVertex, 3>& corners, DepthMap& nearest) {
    const auto& [a, b, c] = corners;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
    const int last_x = static_cast<int>(std::floor(std::min(right, nearest.width - 1.0)));
    const int last_y = static_cast<int>(std::floor(std::min(bottom, nearest.height - 1.0)));
    for (int y = static_cast<int>(std::ceil(std::max(top, 0.0))); y <= last_y; ++y)
        for (int x = static_cast<int>(std::ceil(std::max(left, 0.0))); x <= last_x; ++x) {
            const double of_b = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
            const double of_c = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
            constexpr double rounding = -1e-9;  // a pixel on an edge belongs to both sides
            if (of_b < rounding || of_c < rounding || 1 - of_b - of_c < rounding) continue;
            const double depth = 1 / (a.q + of_b * (b.q - a.q) + of_c * (c.q - a.q));
            double& kept = nearest.depths[nearest.index(x, y)];
            if (kept == 0 || depth < kept) kept = depth;
        }
}

}  // namespace

double DepthMap::at(int x, int y) const {
    return depths[index(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1))];
}

DepthMap depths_of(const RawFrame& raw, const Scene& scene) {
    DepthMap map{scene.width, scene.height, scene.camera, {}};
    map.depths.reserve(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const std::uint16_t code = raw.depth.sample(x, y);
            map.depths.push_back(scene.depth.is_valid(code) ? scene.depth.depth(code) : 0);
        }
    return map;
}

DepthMap scaled(DepthMap map, double factor) {
    for (double& depth : map.depths) depth *= factor;
    return map;
}

Result<DepthMap> seen_from(const DepthMap& map, double way) {
    DepthMap seen{map.width, map.height, map.camera, std::vector<double>(map.depths.size())};
    const auto vertex = [&](int x, int y) {
        const double depth = map.at(x, y), now = depth - way;
        return SeenVertex{map.camera.cx + (x - map.camera.cx) * depth / now,
                          map.camera.cy + (y - map.camera.cy) * depth / now, 1 / now};
    };
    for (int y = 0; y + 1 < map.height; ++y)
        for (int x = 0; x + 1 < map.width; ++x) {
            const double least =
                std::min({map.at(x, y), map.at(x + 1, y), map.at(x, y + 1), map.at(x + 1, y + 1)});
            if (!(least - way > least_depth)) continue;
            const SeenVertex here = vertex(x, y), across = vertex(x + 1, y + 1);
            draw({here, vertex(x + 1, y), across}, seen);
            draw({here, across, vertex(x, y + 1)}, seen);
        }
    if (std::count(seen.depths.begin(), seen.depths.end(), 0.0) > 0)
        return Error{ErrorKind::check, "after " + std::to_string(way) + " mm a pixel sees no surface"};
    return seen;
}

}  // namespace touchable
