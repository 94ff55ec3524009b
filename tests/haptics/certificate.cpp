#include "tests/haptics/certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable::test {

namespace {

using Real = long double;
using Vec = glm::vec<3, long double>;
using Index = std::int64_t;

Real vertex_q(const HeightField& field, Index i, Index j) {
    const Scene& scene = field.scene();
    const Real depth = field.vertex(i, j).depth;
    if (scene.depth.semantics == DepthSemantics::planar) return 1 / depth;
    const Real x = std::clamp<Index>(i, -1, scene.width), y = std::clamp<Index>(j, -1, scene.height);
    const Real u = (x - scene.camera.cx) / scene.camera.fx, v = (y - scene.camera.cy) / scene.camera.fy;
    return std::sqrt(u * u + v * v + 1) / depth;
}

Vec vertex_point(const HeightField& field, Index i, Index j) {
    const Camera& c = field.scene().camera;
    const Real q = vertex_q(field, i, j);
    return {(i - Real(c.cx)) / c.fx / q, -(j - Real(c.cy)) / c.fy / q, -1 / q};
}

/// Nearest point of a triangle, by the regions of its corners, edges and face (Ericson, Real-Time Collision
/// Detection, 5.1.5).
Vec closest_on_triangle(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
    const Vec ab = b - a, ac = c - a, n = glm::cross(ab, ac);
    const Vec foot = p - n * (glm::dot(p - a, n) / glm::dot(n, n));
    const bool inside = glm::dot(glm::cross(ab, foot - a), n) >= 0 &&
                        glm::dot(glm::cross(c - b, foot - b), n) >= 0 &&
                        glm::dot(glm::cross(a - c, foot - c), n) >= 0;
    if (inside) return foot;
    auto on_segment = [&p](const Vec& s, const Vec& e) {
        const Vec d = e - s;
        const Real t = std::clamp(glm::dot(p - s, d) / glm::dot(d, d), Real(0), Real(1));
        return s + d * t;
    };
    std::array<Vec, 3> edges{on_segment(a, b), on_segment(b, c), on_segment(c, a)};
    return *std::min_element(edges.begin(), edges.end(), [&p](const Vec& s, const Vec& t) {
        return glm::dot(s - p, s - p) < glm::dot(t - p, t - p);
    });
}

}  // namespace

long double surface_q(const HeightField& field, double x, double y) {
    const Index i = static_cast<Index>(std::floor(x)), j = static_cast<Index>(std::floor(y));
    const Real a = Real(x) - i, b = Real(y) - j;
    const Real q00 = vertex_q(field, i, j), q11 = vertex_q(field, i + 1, j + 1);
    if (a >= b) {
        const Real q10 = vertex_q(field, i + 1, j);
        return q00 + (q10 - q00) * a + (q11 - q10) * b;
    }
    const Real q01 = vertex_q(field, i, j + 1);
    return q00 + (q01 - q00) * b + (q11 - q01) * a;
}

long double excess_over_minimum(const HeightField& field, const Proxy& proxy, const glm::dvec3& goal) {
    const Vec p(proxy.point), g(goal);
    const Real have = std::sqrt(glm::dot(p - g, p - g));
    Real least = have;
    // Every triangle of the cells around the place that contains it, to far less than a millionth of a pixel.
    for (Index dj = -1; dj <= 0; ++dj)
        for (Index di = -1; di <= 0; ++di) {
            const Index i = static_cast<Index>(std::ceil(proxy.x())) + di;
            const Index j = static_cast<Index>(std::ceil(proxy.y())) + dj;
            for (const Index ci : {i, i + 1})
                for (const Index cj : {j, j + 1}) {
                    const double a = proxy.x() - static_cast<double>(ci),
                                 b = proxy.y() - static_cast<double>(cj);
                    if (a < 0 || a > 1 || b < 0 || b > 1) continue;
                    const Vec v00 = vertex_point(field, ci, cj), v11 = vertex_point(field, ci + 1, cj + 1);
                    for (const bool lower : {true, false}) {
                        if (lower ? a < b : a > b) continue;
                        const Vec apex =
                            lower ? vertex_point(field, ci + 1, cj) : vertex_point(field, ci, cj + 1);
                        const Vec nearest = closest_on_triangle(g, v00, apex, v11);
                        least = std::min(least, std::sqrt(glm::dot(nearest - g, nearest - g)));
                    }
                }
        }
    return have - least;
}

}  // namespace touchable::test
