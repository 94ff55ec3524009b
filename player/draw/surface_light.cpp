#include "player/draw/surface_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "shaders/cut_rule.h"
#include "shaders/surface_light.h"

namespace touchable {
namespace {

/// Sums of the normals of the triangles at each vertex, as long as those are large. Cut triangles have none.
std::vector<glm::vec3> vertex_normals(const Camera& camera, const ViewSurface& surface) {
    std::vector<glm::vec3> normals(surface.q.size(), glm::vec3(0.0F));
    auto point = [&](int x, int y) {
        return unproject(camera, x, y, 1.0 / static_cast<double>(surface.q[surface.index(x, y)]));
    };
    auto add = [&](std::array<glm::ivec2, 3> at) {
        const std::size_t a = surface.index(at[0].x, at[0].y), b = surface.index(at[1].x, at[1].y),
                          c = surface.index(at[2].x, at[2].y);
        if (triangle_is_cut(surface.q[a], surface.q[b], surface.q[c])) return;
        const glm::dvec3 origin = point(at[0].x, at[0].y);
        const glm::vec3 normal =
            glm::cross(point(at[1].x, at[1].y) - origin, point(at[2].x, at[2].y) - origin);
        for (const std::size_t vertex : {a, b, c}) normals[vertex] += normal;
    };
    for (int y = 0; y + 1 < surface.height; ++y)
        for (int x = 0; x + 1 < surface.width; ++x) {
            add({{{x, y}, {x + 1, y + 1}, {x + 1, y}}});
            add({{{x, y}, {x, y + 1}, {x + 1, y + 1}}});
        }
    return normals;
}

/// Replaces each of `count` values by the sum over those at most n away.
template <class At>
void box_sum(int count, int n, At at) {
    std::vector<glm::vec3> values(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) values[static_cast<std::size_t>(k)] = at(k);
    for (int k = 0; k < count; ++k) {
        glm::vec3 sum(0.0F);
        for (int other = std::max(0, k - n); other <= std::min(count - 1, k + n); ++other)
            sum += values[static_cast<std::size_t>(other)];
        at(k) = sum;
    }
}

/// Normals over 5x5 vertices: what a depth camera's steps make of light is no relief.
void smooth(const ViewSurface& surface, std::vector<glm::vec3>& normals) {
    constexpr int reach = 2;
    for (int y = 0; y < surface.height; ++y)
        box_sum(surface.width, reach, [&](int x) -> glm::vec3& { return normals[surface.index(x, y)]; });
    for (int x = 0; x < surface.width; ++x)
        box_sum(surface.height, reach, [&](int y) -> glm::vec3& { return normals[surface.index(x, y)]; });
}

PackedColour packed(const glm::vec3& colour) {
    const glm::uvec3 byte(colour + 0.5F);
    return pack_colour(byte.r, byte.g, byte.b);
}

}  // namespace

UsualQ usual_q(int width, int height, const std::function<float(int x, int y)>& q_at) {
    // Thousands of vertices tell as well as all, and the same ones every time: what stands still keeps its
    // shade.
    constexpr double enough = 8192;
    const int step = 1 + static_cast<int>(std::sqrt(static_cast<double>(width) * height / enough));
    std::vector<float> valid;
    for (int y = 0; y < height; y += step)
        for (int x = 0; x < width; x += step)
            if (const float q = q_at(x, y); q > 0) valid.push_back(q);
    if (valid.empty()) return {0, 1};
    auto quantile = [&valid](std::size_t percent) {
        const auto at = valid.begin() + static_cast<std::ptrdiff_t>((valid.size() - 1) * percent / 100);
        std::nth_element(valid.begin(), at, valid.end());
        return *at;
    };
    return {quantile(4), quantile(96)};
}

std::vector<PackedColour> lit_colours(const Camera& camera, const ViewSurface& surface,
                                      const PlaneView& colour) {
    std::vector<glm::vec3> normals = vertex_normals(camera, surface);
    smooth(surface, normals);
    const auto [farthest_q, nearest_q] =
        usual_q(surface.width, surface.height, [&](int x, int y) { return surface.q[surface.index(x, y)]; });
    const float q_range = std::max(nearest_q - farthest_q, 1e-30F);

    std::vector<PackedColour> colours;
    colours.reserve(surface.q.size());
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < surface.width; ++x) {
            const std::size_t at = surface.index(x, y);
            const double length = glm::length(glm::dvec3(normals[at]));
            const glm::dvec3 normal = length > 0 ? glm::dvec3(normals[at]) / length : glm::dvec3(0, 0, 1);
            const float light = light_on(glm::vec3(normal));
            if (!colour.empty()) {
                const std::uint8_t* rgb = colour.row(y) + std::ptrdiff_t{3} * x;
                colours.push_back(packed(lit_colour(glm::vec3(rgb[0], rgb[1], rgb[2]), light)));
                continue;
            }
            colours.push_back(packed(lit_clay((surface.q[at] - farthest_q) / q_range, light)));
        }
    return colours;
}

}  // namespace touchable
