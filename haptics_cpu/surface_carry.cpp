// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/surface_carry.hpp"

#include <bitset>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "haptics_cpu/cast.hpp"

namespace touchable {

namespace {

using glm::dot;
using glm::dvec3;

dvec3 nearest_on_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
    const dvec3 ab = b - a;
    const double t = dot(p - a, ab), tt = dot(ab, ab);
    if (!(t > 0)) return a;
    return t < tt ? a + ab * (t / tt) : b;
}

/// Uses the regions of corners, edges and face (Ericson, Real-Time Collision Detection, 5.1.5).
dvec3 nearest_on_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 ab = b - a, ac = c - a, ap = p - a;
    const dvec3 n = glm::cross(ab, ac);
    // Barycentric weights of the foot, times |n|^2.
    const double wc = dot(glm::cross(ab, ap), n), wb = dot(glm::cross(ap, ac), n), nn = dot(n, n);
    const double wa = nn - wb - wc;
    if (wa >= 0 && wb >= 0 && wc >= 0 && nn > 0) return a + ab * (wb / nn) + ac * (wc / nn);
    dvec3 nearest = nearest_on_segment(p, a, b);
    for (const dvec3& on_edge : {nearest_on_segment(p, b, c), nearest_on_segment(p, c, a)})
        if (dot(on_edge - p, on_edge - p) < dot(nearest - p, nearest - p)) nearest = on_edge;
    return nearest;
}

/// The vertices of the window, each computed once, when first used.
class Window {
public:
    Window(const WorldSpace& space, std::int64_t i, std::int64_t j)
        : space_(space), i_(i - nearest_window), j_(j - nearest_window) {}
    const dvec3& at(std::int64_t i, std::int64_t j) {
        const auto k = static_cast<std::size_t>((j - j_) * side + (i - i_));
        if (!known_[k]) {
            positions_[k] = space_.vertex(i, j).position;
            known_[k] = true;
        }
        return positions_[k];
    }

private:
    static constexpr int side = 2 * nearest_window + 2;
    const WorldSpace& space_;
    std::int64_t i_, j_;
    std::array<dvec3, side * side> positions_;
    std::bitset<side * side> known_;
};

class Search {
public:
    Search(const WorldSpace& space, const Place& around, const dvec3& point, double within)
        : space_(space), i_(around.i), j_(around.j), point_(point), best_(within), window_(space, i_, j_) {}

    std::optional<Place> run() {
        for (int ring = 0; ring <= nearest_window && !(beyond2(ring) >= best_ * best_); ++ring)
            for (int dj = -ring; dj <= ring; ++dj) {
                const bool whole_row = std::abs(dj) == ring;
                for (int di = -ring; di <= ring; di += whole_row || ring == 0 ? 1 : 2 * ring)
                    look(i_ + di, j_ + dj);
            }
        return found_;
    }

private:
    /// Lower bound of the squared distance of points outside the rings before this one: they are seen through
    /// a window of the picture, whose sides are planes through the camera.
    double beyond2(int ring) const {
        if (ring == 0) return 0;
        const Camera& camera = space_.field().scene().camera;
        auto squared = [&](double across, double slope) {
            const double off = across + slope * point_.z;
            return off * off / (1.0 + slope * slope);
        };
        const auto i = static_cast<double>(i_), j = static_cast<double>(j_);
        return std::min({squared(point_.x, camera.u(i - ring + 1)), squared(point_.x, camera.u(i + ring)),
                         squared(point_.y, camera.v(j - ring + 1)), squared(point_.y, camera.v(j + ring))});
    }

    void look(std::int64_t i, std::int64_t j) {
        const dvec3 &p00 = window_.at(i, j), &p10 = window_.at(i + 1, j), &p01 = window_.at(i, j + 1),
                    &p11 = window_.at(i + 1, j + 1);
        // A cell that lies in front of the point by more than the best distance is no nearer.
        if (std::min({p00.z, p10.z, p01.z, p11.z}) - point_.z >= best_) return;
        consider({Feature::face_lower, i, j}, nearest_on_triangle(point_, p00, p10, p11));
        consider({Feature::face_upper, i, j}, nearest_on_triangle(point_, p00, p11, p01));
    }

    struct Face {
        Feature feature;
        std::int64_t i, j;
    };
    void consider(const Face& face, const dvec3& candidate) {
        const dvec3 off = candidate - point_;
        const double squared = dot(off, off);
        if (!(squared < best_ * best_)) return;
        const auto at = space_.chart(candidate);
        if (!at) return;
        best_ = std::sqrt(squared);
        found_ = face_or_rim_place(face.feature, face.i, face.j, at->x - static_cast<double>(face.i),
                                   at->y - static_cast<double>(face.j));
    }

    const WorldSpace& space_;
    std::int64_t i_, j_;
    dvec3 point_;
    double best_;
    Window window_;
    std::optional<Place> found_;
};

// A slope of up to 60 degrees that rises along the ray comes no nearer than this share of the way: there the
// ray is right. The sides of objects come far nearer.
constexpr double much_nearer = 0.5;

/// Lifts a free proxy onto a surface that rose past it, on its ray. False if it did not.
bool lift(const auto& space, Proxy& proxy) {
    const auto at = space.chart(proxy.point);
    if (!at) return false;
    const Place under = face_under(at->x, at->y);
    if (!(at->w < surface_w(space, under))) return false;
    proxy = {under, surface_point(space, under)};
    return true;
}

/// False if the proxy left its ray.
[[gnu::noinline]] bool carry_suddenly(const WorldSpace& space, Proxy& proxy, const dvec3& was,
                                      double distance) {
    if (proxy.point.z < was.z) {
        proxy = {{}, was};
        return false;
    }
    const auto aside = nearest_place(space, proxy, was, much_nearer * distance);
    if (!aside) return true;
    proxy = {*aside, surface_point(space, *aside), proxy.sliding};
    return false;
}

}  // namespace

std::optional<Place> nearest_place(const WorldSpace& space, const Place& around, const dvec3& point,
                                   double within) {
    return Search(space, around, point, within).run();
}

template <class Space>
bool carry(const Space& space, Proxy& proxy, double sudden) {
    const dvec3 was = proxy.point;
    if (proxy.on_surface())
        proxy.point = surface_point(space, proxy);
    else if (!lift(space, proxy))
        return true;
    if constexpr (std::is_same_v<Space, WorldSpace>) {
        const dvec3 way = proxy.point - was;
        const double squared = dot(way, way);
        if (squared > sudden * sudden) return carry_suddenly(space, proxy, was, std::sqrt(squared));
    }
    return true;
}

template bool carry(const WorldSpace&, Proxy&, double);
template bool carry(const PixelSpace&, Proxy&, double);

}  // namespace touchable
