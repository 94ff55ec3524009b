// SPDX-License-Identifier: Apache-2.0
#include "bench/real/depth_plane.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

constexpr int block = 8;  // pixels whose residuals count as one observation

/// Sum of (i - x)^2 over the window: equal for both axes, which are independent.
double sum_of_squares(int reach) {
    double squares = 0;
    for (int d = -reach; d <= reach; ++d) squares += d * d;
    return squares * (2 * reach + 1);
}

}  // namespace

std::optional<DepthPlane> plane_around(const DepthMap& map, int x, int y, int reach) {
    if (x < reach || y < reach || x >= map.width - reach || y >= map.height - reach) return std::nullopt;
    double sum = 0, along_x = 0, along_y = 0, square = 0;
    // Relative to the middle's 1 / depth, so that the sums of squares lose no precision.
    const double middle = map.depths[map.index(x, y)];
    if (middle == 0) return std::nullopt;
    for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
            const double depth = map.depths[map.index(x + dx, y + dy)];
            if (depth == 0) return std::nullopt;
            const double q = 1 / depth - 1 / middle;
            sum += q;
            along_x += dx * q;
            along_y += dy * q;
            square += q * q;
        }
    const double count = (2 * reach + 1) * (2 * reach + 1), squares = sum_of_squares(reach);
    DepthPlane plane{x, y, 1 / middle + sum / count, along_x / squares, along_y / squares, 0};
    const double rest = square - sum * sum / count - plane.right * along_x - plane.down * along_y;
    plane.residual_mm = std::sqrt(std::max(rest, 0.0) / count) / (plane.at * plane.at);
    return plane;
}

std::vector<DepthPlane> flat_places(const DepthMap& map, int step, int reach, const DepthLength& flat) {
    std::vector<DepthPlane> places;
    for (int y = reach; y < map.height - reach; y += step)
        for (int x = reach; x < map.width - reach; x += step) {
            const auto plane = plane_around(map, x, y, reach);
            if (!plane) continue;
            const double depth = 1 / plane->at;
            if (plane->residual_mm <= flat.at(depth)) places.push_back(*plane);
        }
    return places;
}

glm::dvec3 normal_of(const DepthPlane& plane, const Camera& camera) {
    const double straight_ahead =
        plane.at + plane.right * (camera.cx - plane.x) + plane.down * (camera.cy - plane.y);
    return glm::normalize(glm::dvec3(-plane.right * camera.fx, plane.down * camera.fy, straight_ahead));
}

double standard_error_deg(const DepthMap& map, const DepthPlane& plane, int reach) {
    struct Scores {
        double x = 0, y = 0;
    };
    std::map<std::pair<int, int>, Scores> blocks;
    for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
            const double rest = 1 / map.depths[map.index(plane.x + dx, plane.y + dy)] -
                                (plane.at + plane.right * dx + plane.down * dy);
            Scores& scores = blocks[{(dx + reach) / block, (dy + reach) / block}];
            scores.x += dx * rest;
            scores.y += dy * rest;
        }
    double x = 0, y = 0;
    for (const auto& [place, scores] : blocks) {
        x += scores.x * scores.x;
        y += scores.y * scores.y;
    }
    const double squares = sum_of_squares(reach);
    DepthPlane to_the_right = plane, downwards = plane;
    to_the_right.right += std::sqrt(x) / squares;
    downwards.down += std::sqrt(y) / squares;
    const glm::dvec3 normal = normal_of(plane, map.camera);
    const double a = degrees_between(normal, normal_of(to_the_right, map.camera)),
                 b = degrees_between(normal, normal_of(downwards, map.camera));
    return std::sqrt(a * a + b * b);
}

}  // namespace touchable
