#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "shaders/view_project.h"

namespace touchable {

/// A corner in clip space (ViewCamera) and what goes with it: a colour, a normal, or the like.
struct FillCorner {
    glm::vec4 clip;
    glm::vec3 value;
};

namespace fill {

struct Point {
    std::int64_t x, y;  // subpixels
    float z;
    float share;      // 1 / w
    glm::vec3 value;  // times that
};

/// Twice the signed area of a, b, (x, y); positive where these go clockwise on the screen.
inline std::int64_t edge(const Point& a, const Point& b, std::int64_t x, std::int64_t y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}
/// A pixel centre on an edge belongs to the triangle where that is its upper or left edge.
inline std::int64_t least_inside(const Point& a, const Point& b) {
    return b.y < a.y || (b.y == a.y && b.x > a.x) ? 0 : 1;
}
inline Point to_screen(const FillCorner& corner, int width, int height) {
    const glm::vec4& c = corner.clip;
    return {view_subpixels(c.x / c.w, static_cast<float>(width)),
            view_subpixels(c.y / c.w, static_cast<float>(height)), c.z / c.w, 1.0F / c.w,
            corner.value * (1.0F / c.w)};
}
/// Pixels whose centres lie within [least, greatest] subpixels, as [first, last] on a side of `size`.
inline std::array<int, 2> pixels_between(std::int64_t least, std::int64_t greatest, int size) {
    constexpr std::int64_t half = VIEW_SUBPIXELS / 2;
    const std::int64_t first = (least - half + VIEW_SUBPIXELS - 1) >> 8, last = (greatest - half) >> 8;
    return {static_cast<int>(std::clamp<std::int64_t>(first, 0, size)),
            static_cast<int>(std::clamp<std::int64_t>(last, -1, size - 1))};
}

template <class Plot>
void triangle(const Point& a, Point b, Point c, int width, int height, Plot& plot) {
    std::int64_t area = edge(a, b, c.x, c.y);
    if (area == 0) return;
    if (area < 0) {
        std::swap(b, c);
        area = -area;
    }
    const auto [x0, x1] = pixels_between(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), width);
    const auto [y0, y1] = pixels_between(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), height);
    const float scale = 1.0F / static_cast<float>(area);
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const std::int64_t px = x * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2,
                               py = y * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2;
            const std::int64_t ab = edge(a, b, px, py), bc = edge(b, c, px, py), ca = edge(c, a, px, py);
            if (ab < least_inside(a, b) || bc < least_inside(b, c) || ca < least_inside(c, a)) continue;
            const float of_b = static_cast<float>(ca) * scale, of_c = static_cast<float>(ab) * scale;
            const float share = a.share + of_b * (b.share - a.share) + of_c * (c.share - a.share);
            plot(x, y, a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z),
                 (a.value + of_b * (b.value - a.value) + of_c * (c.value - a.value)) / share);
        }
}

}  // namespace fill

/// Calls plot(x, y, z, value) for every pixel whose centre the triangle covers, seen from either side: exact
/// in subpixels of 1/256, so that triangles that share an edge neither overlap nor leave a gap. What is
/// before the near plane is cut off. z is linear on the screen, value on the triangle in space.
template <class Plot>
void fill_triangle(const std::array<FillCorner, 3>& corners, int width, int height, Plot&& plot) {
    std::array<fill::Point, 4> points;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const FillCorner &from = corners[k], &to = corners[(k + 1) % 3];
        const float inside_from = from.clip.w - from.clip.z, inside_to = to.clip.w - to.clip.z;
        if (inside_from >= 0) points[count++] = fill::to_screen(from, width, height);
        if ((inside_from >= 0) == (inside_to >= 0)) continue;
        const float share = inside_from / (inside_from - inside_to);
        FillCorner crossing{from.clip + share * (to.clip - from.clip),
                            from.value + share * (to.value - from.value)};
        crossing.clip.z = crossing.clip.w;
        points[count++] = fill::to_screen(crossing, width, height);
    }
    if (count >= 3) fill::triangle(points[0], points[1], points[2], width, height, plot);
    if (count == 4) fill::triangle(points[0], points[2], points[3], width, height, plot);
}

}  // namespace touchable
