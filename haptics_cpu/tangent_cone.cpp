#include "haptics_cpu/tangent_cone.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "haptics_cpu/pixel_space.hpp"
#include "haptics_cpu/world_space.hpp"

namespace touchable {

namespace {

using glm::cross;
using glm::dot;
using glm::dvec3;

struct CellFace {
    Feature feature;
    std::int64_t i, j;
};

/// The outward normal (any length) of a face whose corners come clockwise in the image; seen so, the third
/// side x the first points towards the camera. From the sides that meet at the corner nearest to the camera:
/// the coordinates of far corners are rounded by more than near ones are apart.
template <class Vertex>
dvec3 normal_of(const Vertex& a, const Vertex& b, const Vertex& c) {
    if (a.w >= b.w && a.w >= c.w) return cross(c.position - a.position, b.position - a.position);
    if (b.w >= c.w) return cross(a.position - b.position, c.position - b.position);
    return cross(b.position - c.position, a.position - c.position);
}

// What is found out is written where it will be read: copies of what was just stored in pieces stall.

/// Along a face with the outward normal n (any length).
void along_face(const CellFace& face, const dvec3& n, const dvec3& pull, Motion& motion) {
    motion.kind = Motion::Kind::face;
    motion.feature = face.feature;
    motion.i = face.i;
    motion.j = face.j;
    const double vn = dot(pull, n), nn = dot(n, n);
    // A face that doubles take for a line leads nowhere.
    motion.way = nn > 0 ? pull - n * (vn / nn) : dvec3(0.0);
    // A pull off the face, of a proxy that may not leave for now, presses nothing: friction does not hold it.
    motion.load2 = vn < 0 && nn > 0 ? vn * vn / nn : 0.0;
}

/// Along an edge between faces with the outward normals n0 and n1. In a valley G - C = -(l0 n0 + l1 n1) for
/// unit normals; the sum l0 + l1 needs no division by their small difference.
void along_edge(Feature edge, std::int64_t i, std::int64_t j, const dvec3& way, const dvec3& pull,
                const dvec3& n0, const dvec3& n1, Motion& motion) {
    motion.kind = Motion::Kind::edge;
    motion.feature = edge;
    motion.i = i;
    motion.j = j;
    motion.way = way;
    motion.load2 = 0;
    const double length0 = std::sqrt(dot(n0, n0)), length1 = std::sqrt(dot(n1, n1));
    if (!(length0 * length1 > 0)) return;
    const double pressed = -(dot(pull, n0) / length0 + dot(pull, n1) / length1);
    const double opening = 1.0 + dot(n0, n1) / (length0 * length1);
    if (pressed > 0) {
        const double load = opening > 0 ? pressed / opening : std::numeric_limits<double>::infinity();
        motion.load2 = load * load;
    }
}

template <class Space>
void on_face(const Space& space, const Place& at, const dvec3& pull, bool may_leave, Motion& motion) {
    const bool lower = at.feature == Feature::face_lower;
    const SpaceVertex &first = space.vertex(at.i, at.j), &second = space.vertex(at.i + 1, at.j + 1);
    const SpaceVertex& apex = space.vertex(at.i + lower, at.j + !lower);
    const dvec3 n = lower ? normal_of(first, apex, second) : normal_of(first, second, apex);
    if (may_leave && dot(pull, n) > 0) {
        motion.kind = Motion::Kind::leave;
        return;
    }
    along_face({at.feature, at.i, at.j}, n, pull, motion);
    motion.corners_valid =
        first.valid && second.valid && apex.valid && space.is_valid(at.i + !lower, at.j + lower);
}

/// One face beside an edge: its place, its vertex off the edge.
struct EdgeSide {
    CellFace face;
    std::int64_t apex_i, apex_j;
};

/// The faces of an edge: first the one counterclockwise of it in the image.
std::array<EdgeSide, 2> sides_of(const Place& at) {
    const std::int64_t i = at.i, j = at.j;
    using enum Feature;
    switch (at.feature) {
        case edge_h:
            return {{{{face_upper, i, j - 1}, i, j - 1}, {{face_lower, i, j}, i + 1, j + 1}}};
        case edge_v:
            return {{{{face_upper, i, j}, i + 1, j + 1}, {{face_lower, i - 1, j}, i - 1, j}}};
        default:
            return {{{{face_lower, i, j}, i + 1, j}, {{face_upper, i, j}, i, j + 1}}};
    }
}

/// Whether an image direction points to the first of these faces.
bool points_to_first(Feature edge, const ImageStep& step) {
    switch (edge) {
        case Feature::edge_h:
            return step.dy <= 0;
        case Feature::edge_v:
            return step.dx >= 0;
        default:
            return step.dx >= step.dy;
    }
}

template <class Space>
void on_edge(const Space& space, const Place& at, const dvec3& point, const dvec3& pull, bool may_leave,
             Motion& motion) {
    const std::int64_t end_i = at.i + (at.feature == Feature::edge_v ? 0 : 1);
    const std::int64_t end_j = at.j + (at.feature == Feature::edge_h ? 0 : 1);
    const SpaceVertex &first = space.vertex(at.i, at.j), &last = space.vertex(end_i, end_j);
    const dvec3 e = last.position - first.position;
    const auto sides = sides_of(at);
    const SpaceVertex& apex0 = space.vertex(sides[0].apex_i, sides[0].apex_j);
    const SpaceVertex& apex1 = space.vertex(sides[1].apex_i, sides[1].apex_j);
    const bool valid = first.valid && last.valid && apex0.valid && apex1.valid;
    // Towards the camera; and within the face away from the edge.
    const std::array<dvec3, 2> normal{normal_of(first, apex0, last), normal_of(first, last, apex1)};
    const std::array<dvec3, 2> inward{cross(normal[0], e), cross(e, normal[1])};
    if (may_leave) {
        const bool off_first = dot(pull, normal[0]) > 0, off_second = dot(pull, normal[1]) > 0;
        // Off one face and not the other: the face that the pull's image falls on decides.
        const bool leaves =
            off_first == off_second || points_to_first(at.feature, space.image_step(point, pull))
                ? off_first
                : off_second;
        if (leaves) {
            motion.kind = Motion::Kind::leave;
            return;
        }
    }
    // Along the face that descends; on a ridge, where both do, along the one that brings the goal nearer.
    const double descent0 = dot(pull, inward[0]), descent1 = dot(pull, inward[1]);
    if (descent0 > 0 || descent1 > 0) {
        const bool to_first =
            descent0 > 0 && (!(descent1 > 0) || descent0 * descent0 * dot(inward[1], inward[1]) >=
                                                    descent1 * descent1 * dot(inward[0], inward[0]));
        const std::size_t k = to_first ? 0 : 1;
        along_face(sides[k].face, normal[k], pull, motion);
    } else {
        const double along = dot(pull, e);
        if (along == 0) return;
        along_edge(at.feature, at.i, at.j, e * (along / dot(e, e)), pull, normal[0], normal[1], motion);
    }
    motion.corners_valid = valid;
}

/// The six edges around a vertex, clockwise in the image from +x, and the faces between each and the next.
struct Spoke {
    int di, dj;
    Feature edge;
    int edge_di, edge_dj;  // where the edge starts
    Feature face;          // between this spoke and the next
    int face_di, face_dj;  // its cell
};
constexpr std::array<Spoke, 6> spokes{{
    {1, 0, Feature::edge_h, 0, 0, Feature::face_lower, 0, 0},
    {1, 1, Feature::edge_d, 0, 0, Feature::face_upper, 0, 0},
    {0, 1, Feature::edge_v, 0, 0, Feature::face_lower, -1, 0},
    {-1, 0, Feature::edge_h, -1, 0, Feature::face_upper, -1, -1},
    {-1, -1, Feature::edge_d, -1, -1, Feature::face_lower, -1, -1},
    {0, -1, Feature::edge_v, 0, -1, Feature::face_upper, 0, -1},
}};

/// Which face around a vertex an image direction falls on.
std::size_t sector_of(const ImageStep& step) {
    if (step.dy >= 0) {
        if (step.dx >= step.dy) return 0;
        return step.dx >= 0 ? 1 : 2;
    }
    if (step.dx <= step.dy) return 3;
    return step.dx <= 0 ? 4 : 5;
}

template <class Space>
void on_vertex(const Space& space, std::int64_t i, std::int64_t j, const dvec3& point, const dvec3& pull,
               bool may_leave, Motion& motion) {
    std::array<dvec3, 6> e, n;
    const SpaceVertex& middle = space.vertex(i, j);
    std::array<const SpaceVertex*, 6> around;
    motion.corners_valid = middle.valid;
    for (std::size_t k = 0; k < 6; ++k) {
        around[k] = &space.vertex(i + spokes[k].di, j + spokes[k].dj);
        e[k] = around[k]->position - middle.position;
        motion.corners_valid &= around[k]->valid;
    }
    for (std::size_t k = 0; k < 6; ++k) n[k] = normal_of(middle, *around[k], *around[(k + 1) % 6]);

    if (may_leave && dot(pull, n[sector_of(space.image_step(point, pull))]) > 0) {
        motion.kind = Motion::Kind::leave;
        return;
    }

    // A face that holds the projection is longer than its edges. Squares cannot always tell: of a pull a
    // million times as long as what would be left of it beside the edge they are the same.
    double longest = 0;
    int face = -1, edge = -1;
    std::array<bool, 6> in_sector{};
    for (std::size_t k = 0; k < 6; ++k) {
        const double vn = dot(pull, n[k]), nn = dot(n[k], n[k]);
        in_sector[k] =
            nn > 0 && dot(pull, cross(e[k], n[k])) > 0 && dot(pull, cross(n[k], e[(k + 1) % 6])) > 0;
        if (!in_sector[k]) continue;
        const double length2 = dot(pull, pull) - vn * vn / nn;
        in_sector[k] = length2 > 0;  // of a pull along the normal nothing is left but roundings
        if (length2 > longest) {
            longest = length2;
            face = static_cast<int>(k);
        }
    }
    for (std::size_t k = 0; k < 6; ++k) {
        const double along = dot(pull, e[k]);
        if (!(along > 0) || in_sector[k] || in_sector[(k + 5) % 6]) continue;
        const double length2 = along * along / dot(e[k], e[k]);
        if (length2 > longest) {
            longest = length2;
            edge = static_cast<int>(k);
        }
    }
    if (edge >= 0) {
        const auto k = static_cast<std::size_t>(edge);
        const Spoke& spoke = spokes[k];
        const dvec3 way = e[k] * (dot(pull, e[k]) / dot(e[k], e[k]));
        along_edge(spoke.edge, i + spoke.edge_di, j + spoke.edge_dj, way, pull, n[(k + 5) % 6], n[k], motion);
    } else if (face >= 0) {
        const auto k = static_cast<std::size_t>(face);
        along_face({spokes[k].face, i + spokes[k].face_di, j + spokes[k].face_dj}, n[k], pull, motion);
    }
}

}  // namespace

template <class Space>
Motion project_on_tangent_cone(const Space& space, const Proxy& proxy, const dvec3& point, const dvec3& pull,
                               bool may_leave) {
    Motion motion;
    switch (proxy.feature) {
        case Feature::free:
            break;
        case Feature::face_lower:
        case Feature::face_upper:
            on_face(space, proxy, pull, may_leave, motion);
            break;
        case Feature::vertex:
            on_vertex(space, proxy.i, proxy.j, point, pull, may_leave, motion);
            break;
        default:
            on_edge(space, proxy, point, pull, may_leave, motion);
    }
    return motion;
}

template Motion project_on_tangent_cone(const WorldSpace&, const Proxy&, const dvec3&, const dvec3&, bool);
template Motion project_on_tangent_cone(const PixelSpace&, const Proxy&, const dvec3&, const dvec3&, bool);

}  // namespace touchable
