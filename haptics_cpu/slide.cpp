// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/slide.hpp"

#include <glm/geometric.hpp>

#include "haptics_cpu/cast.hpp"

namespace touchable {

namespace {

using glm::cross;
using glm::dot;
using glm::dvec3;

struct CellFace {
    Feature feature;
    std::int64_t i, j;
};

/// The outward normal (any length) of a face whose corners are clockwise in the image; seen from the camera,
/// the third side x the first points towards it. From the sides that meet at the corner nearest to the
/// camera: the coordinates of far corners are rounded by more than the distance between near ones.
template <class Vertex>
dvec3 normal_of(const Vertex& a, const Vertex& b, const Vertex& c) {
    if (a.w >= b.w && a.w >= c.w) return cross(c.position - a.position, b.position - a.position);
    if (b.w >= c.w) return cross(a.position - b.position, c.position - b.position);
    return cross(b.position - c.position, a.position - c.position);
}

// Results are written where they will be read: copies of what was just stored in pieces stall.

/// Motion along a face with the outward normal n (any length).
void along_face(const CellFace& face, const dvec3& n, const dvec3& pull, Motion& motion) {
    motion.kind = Motion::Kind::face;
    motion.feature = face.feature;
    motion.i = face.i;
    motion.j = face.j;
    const double vn = dot(pull, n), nn = dot(n, n);
    // A face that is a line in doubles leads nowhere.
    motion.way = nn > 0 ? pull - n * (vn / nn) : dvec3(0.0);
    // A pull off the face, of a proxy that may not leave for now, has no load: friction does not hold it.
    motion.load2 = vn < 0 && nn > 0 ? vn * vn / nn : 0.0;
}

/// Motion along an edge between faces with the outward normals n0 and n1. In a valley G - C = -(l0 n0 + l1
/// n1) for unit normals; the sum l0 + l1 needs no division by their small difference.
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

void on_face(const auto& space, const Place& at, const dvec3& pull, bool may_leave, Motion& motion) {
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

/// One face beside an edge, and its vertex off the edge.
struct EdgeSide {
    CellFace face;
    std::int64_t apex_i, apex_j;
};

/// The faces of an edge: first the counterclockwise one in the image.
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

void on_edge(const auto& space, const Place& at, const dvec3& point, const dvec3& pull, bool may_leave,
             Motion& motion) {
    const std::int64_t end_i = at.i + (at.feature == Feature::edge_v ? 0 : 1);
    const std::int64_t end_j = at.j + (at.feature == Feature::edge_h ? 0 : 1);
    const SpaceVertex &first = space.vertex(at.i, at.j), &last = space.vertex(end_i, end_j);
    const dvec3 e = last.position - first.position;
    const auto sides = sides_of(at);
    const SpaceVertex& apex0 = space.vertex(sides[0].apex_i, sides[0].apex_j);
    const SpaceVertex& apex1 = space.vertex(sides[1].apex_i, sides[1].apex_j);
    const bool valid = first.valid && last.valid && apex0.valid && apex1.valid;
    // Normals point towards the camera; `inward` lies within the face, away from the edge.
    const std::array<dvec3, 2> normal{normal_of(first, apex0, last), normal_of(first, last, apex1)};
    const std::array<dvec3, 2> inward{cross(normal[0], e), cross(e, normal[1])};
    if (may_leave) {
        const bool off_first = dot(pull, normal[0]) > 0, off_second = dot(pull, normal[1]) > 0;
        // Off one face and not the other: the face in which the pull's image lies decides.
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

/// The face around a vertex in which an image direction lies.
std::size_t sector_of(const ImageStep& step) {
    if (step.dy >= 0) {
        if (step.dx >= step.dy) return 0;
        return step.dx >= 0 ? 1 : 2;
    }
    if (step.dx <= step.dy) return 3;
    return step.dx <= 0 ? 4 : 5;
}

void on_vertex(const auto& space, std::int64_t i, std::int64_t j, const dvec3& point, const dvec3& pull,
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

    // The projection on a face that contains it is longer than those on its edges. Squares cannot always show
    // that: for a pull a million times as long as its part beside the edge they are the same.
    double longest = 0;
    int face = -1, edge = -1;
    std::array<bool, 6> in_sector{};
    for (std::size_t k = 0; k < 6; ++k) {
        const double vn = dot(pull, n[k]), nn = dot(n[k], n[k]);
        in_sector[k] =
            nn > 0 && dot(pull, cross(e[k], n[k])) > 0 && dot(pull, cross(n[k], e[(k + 1) % 6])) > 0;
        if (!in_sector[k]) continue;
        const double length2 = dot(pull, pull) - vn * vn / nn;
        in_sector[k] = length2 > 0;  // for a pull along the normal only roundings are left
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

/// Edges of a face on which a move starts; it does not leave through them, whatever rounding says.
struct StartEdges {
    bool h = false, v = false, d = false;
};

StartEdges start_edges(Feature feature, Feature face, double a, double b) {
    StartEdges on;
    if (feature == Feature::edge_h) on.h = true;
    if (feature == Feature::edge_v) on.v = true;
    if (feature == Feature::edge_d) on.d = true;
    if (feature == Feature::vertex) {
        on.d = a == b;
        on.h = face == Feature::face_lower ? b == 0 : b == 1;
        on.v = face == Feature::face_lower ? a == 1 : a == 0;
    }
    return on;
}

struct FaceExit {
    double length = std::numeric_limits<double>::infinity();  // in units of the image step
    Feature edge = Feature::free;
};

/// Where the ray (a, b) + length (dx, dy) leaves a face of its cell.
FaceExit exit_of_face(Feature face, double a, double b, double dx, double dy, const StartEdges& started) {
    FaceExit exit;
    auto consider = [&exit](bool start, Feature edge, double distance, double speed) {
        if (start || !(speed > 0)) return;
        const double length = std::max(0.0, distance / speed);
        if (length < exit.length) exit = {length, edge};
    };
    if (face == Feature::face_lower) {
        consider(started.h, Feature::edge_h, b, -dy);
        consider(started.v, Feature::edge_v, 1.0 - a, dx);
        consider(started.d, Feature::edge_d, a - b, dy - dx);
    } else {
        consider(started.h, Feature::edge_h, 1.0 - b, dy);
        consider(started.v, Feature::edge_v, a, -dx);
        consider(started.d, Feature::edge_d, b - a, dx - dy);
    }
    return exit;
}

/// The place on the rim where a motion leaves a face of cell (motion.i, motion.j).
Place rim_place(const Motion& motion, const ImageStep& step, const CellPoint& from, const FaceExit& exit) {
    const bool lower = motion.feature == Feature::face_lower;
    const int below = exit.edge == Feature::edge_h && !lower, right = exit.edge == Feature::edge_v && lower;
    return edge_place(
        exit.edge, motion.i + right, motion.j + below,
        exit.edge == Feature::edge_v ? from.b + exit.length * step.dy : from.a + exit.length * step.dx);
}

/// Moves a place that is a rounding beside the end of its edge onto the vertex, where other faces count.
Place at_the_vertex(const Place& at) {
    const auto snapped = [](double f) { return f < 0x1p-48 ? 0.0 : (f > 1 - 0x1p-48 ? 1.0 : f); };
    const double a = snapped(at.a), b = snapped(at.b);
    if (at.feature == Feature::edge_v) return edge_place(at.feature, at.i, at.j, b);
    if (at.feature == Feature::edge_h || at.feature == Feature::edge_d)
        return edge_place(at.feature, at.i, at.j, a);
    return at;
}

/// Whether the distance to the goal is the same after such a way: it is then gone whole, without friction,
/// which could end ever shorter ways and never let it arrive.
bool too_short_to_tell(const Motion& motion, const dvec3& pull) {
    return dot(motion.way, motion.way) <= 0x1p-52 * dot(pull, pull);
}

/// Whether a way is made of roundings. A proxy that may not leave would go to and fro on such a way.
bool is_rounding(const Motion& motion, const dvec3& pull) {
    return dot(motion.way, motion.way) <= 0x1p-96 * dot(pull, pull);
}

constexpr int stall_limit = 8;
constexpr FrictionCone no_friction{};

/// One solve: the proxy's place and point, and how far from the goal it is.
template <class Space>
class Slide {
public:
    Slide(const Space& space, Proxy& proxy, const dvec3& goal, const Slip& slip, SolveCounts& counts)
        : space_(space), proxy_(proxy), goal_(goal), slip_(slip), counts_(counts) {}

    void run(const SolveLimits& limits) {
        bool may_leave = true;
        int stalls = 0;
        while (true) {
            if (counts_.events >= limits.events || counts_.cells >= limits.cells) {
                counts_.capped = true;
                return;
            }
            ++counts_.events;
            const dvec3 pull = goal_ - proxy_.point;
            const Motion motion = project_on_tangent_cone(space_, proxy_, proxy_.point, pull, may_leave);
            if (motion.kind == Motion::Kind::stay) {
                if (settled(may_leave, stalls)) return rest();
                continue;
            }
            Place next;
            bool sliding = false, arrived = false;
            if (motion.kind == Motion::Kind::leave) {
                const Cast flight = cast(space_, proxy_.point, &proxy_, goal_, counts_.cells, limits.cells);
                if (flight.cut) {
                    counts_.capped = true;
                    return fly_to(*flight.cut);
                }
                if (!flight.hit) return fly_to(goal_);
                next = *flight.hit;
            } else {
                const FrictionCone cone = friction_cone(space_, proxy_, motion, slip_);
                if (rests(cone, motion) || (!may_leave && is_rounding(motion, pull))) {
                    if (settled(may_leave, stalls)) return rest();
                    continue;
                }
                // A place reached with friction may have another cone than the start: look again.
                const bool whole = stalls > 0 && too_short_to_tell(motion, pull);
                arrived = move(motion, whole ? no_friction : cone, next) && cone.stopping == 0;
                if (whole) {
                    next = at_the_vertex(next);
                    arrived &= next.feature == motion.feature;
                }
                // Also without friction yet: a proxy in motion is in motion when it meets friction.
                sliding = space_.field().has_friction();
            }
            const Progress progress = take(next, sliding, pull);
            if (progress == Progress::nearer) {
                if (arrived && may_leave && is_foot(motion, pull)) return;
                stalls = 0;
                may_leave = true;  // also if it had to stay, and came to its foot on the surface
                continue;
            }
            // Rounding can make a flight off the surface end where it began, or a step end on the other side
            // of an edge at the same distance. Go on along the surface, a few times in a row at most.
            if (arrived || ++stalls > stall_limit || (progress == Progress::none && !may_leave))
                return rest();
            may_leave = false;
        }
    }

private:
    bool move(const Motion& motion, const FrictionCone& cone, Place& to) {
        ++counts_.cells;
        const ImageStep step = space_.image_step(proxy_.point, motion.way);
        return motion.kind == Motion::Kind::face ? move_over_face(motion, step, cone, to)
                                                 : move_along_edge(motion, step, cone, to);
    }

    /// True if it went as far as friction allows and is inside the face: on the rim the other side counts,
    /// too.
    bool move_over_face(const Motion& motion, const ImageStep& step, const FrictionCone& cone,
                        Place& to) const {
        const CellPoint from = in_cell_of(motion, proxy_);
        const FaceExit exit = exit_of_face(motion.feature, from.a, from.b, step.dx, step.dy,
                                           start_edges(proxy_.feature, motion.feature, from.a, from.b));
        double length = stopping_length(cone, motion, step, from, exit.length);
        if (length < exit.length && cone.presumed && !is_as_presumed(space_, motion, slip_))
            length =
                stopping_length(uneven_cone(space_, proxy_, motion, slip_), motion, step, from, exit.length);
        if (length < exit.length) {
            to = face_or_rim_place(motion.feature, motion.i, motion.j, from.a + length * step.dx,
                                   from.b + length * step.dy);
            return to.feature == motion.feature;
        }
        if (exit.edge == Feature::free) {  // no way out and no motion: length 0
            to = proxy_;
            return true;
        }
        to = rim_place(motion, step, from, exit);
        return false;
    }

    /// True if it went as far as friction allows.
    bool move_along_edge(const Motion& motion, const ImageStep& step, const FrictionCone& cone,
                         Place& to) const {
        const bool vertical = motion.feature == Feature::edge_v;
        const CellPoint from = in_cell_of(motion, proxy_);
        const double start = vertical ? from.b : from.a, speed = vertical ? step.dy : step.dx;
        // An edge so steep that its image is a point has no end in the image.
        const double reach = speed == 0 ? std::numeric_limits<double>::infinity()
                                        : (speed > 0 ? 1.0 - start : start) / std::abs(speed);
        // Roundings across the edge are no motion.
        const ImageStep along{vertical ? 0.0 : speed, motion.feature == Feature::edge_h ? 0.0 : speed,
                              step.stretch};
        const double length = stopping_length(cone, motion, along, from, reach);
        const double end = length < reach ? start + length * speed : (speed > 0 ? 1.0 : 0.0);
        to = edge_place(motion.feature, motion.i, motion.j, speed == 0 ? start : end);
        return to.feature != Feature::vertex;
    }

    /// Whether the new place is where the way ended, as far as the remaining pull can show. On a face seen
    /// edge-on by a billionth of its depth the image of a way is known to few digits, and a way that is long
    /// beside the remaining pull ends where its own roundings put it: then it is gone once more from there.
    bool is_foot(const Motion& motion, const dvec3& pull) const {
        const dvec3 left = goal_ - proxy_.point, aside = left - (pull - motion.way);
        return dot(aside, aside) <= 1e-20 * dot(left, left);
    }

    enum class Progress { nearer, same, none };

    /// How far the roundings of its w move a place: far, if a cell reaches from near the camera to far away.
    double misplaced_by(const Place& at, const dvec3& point) const {
        double largest = 0;
        for (const int dj : {0, 1})
            for (const int di : {0, 1})
                largest = std::max(largest, std::abs(space_.vertex(at.i + di, at.j + dj).w));
        const double w = surface_w(space_, at) + largest * 0x1p-49;
        return glm::distance(space_.position({at.x(), at.y(), w}), point);
    }

    /// Whether roundings explain that the goal is farther from a new place than from this one. By a millionth
    /// at most: beside the camera's plane they could explain anything, and a step there would wind up the
    /// spring.
    bool is_explained(double before, double after, const Place& next, const dvec3& point) const {
        return after <= before * (1.0 + 1e-6) &&
               after <= before + misplaced_by(proxy_, proxy_.point) + misplaced_by(next, point);
    }

    /// Whether a place is certainly nearer to the goal, if squares of the distance cannot show it: for a goal
    /// a billion units away they are the same all over the picture. Before^2 - after^2 is the step times the
    /// sum of both pulls; the roundings of the step's ends are not known.
    bool is_surely_nearer(const dvec3& point, const dvec3& pull, const dvec3& rest) const {
        const dvec3 both = pull + rest;
        const double ends = glm::length(point) + glm::length(proxy_.point);
        return dot(point - proxy_.point, both) > 0x1p-48 * ends * glm::length(both);
    }

    /// Takes the new place unless it is farther from the goal than rounding explains.
    Progress take(const Place& next, bool sliding, const dvec3& pull) {
        const dvec3 point = surface_point(space_, next);
        const dvec3 rest = goal_ - point;
        const double before = dot(pull, pull), after = dot(rest, rest);
        if (!(after <= before * (1.0 + 1e-13)) &&
            !is_explained(std::sqrt(before), std::sqrt(after), next, point))
            return Progress::none;
        const bool nearer = after < std::min(least_, before) || is_surely_nearer(point, pull, rest);
        static_cast<Place&>(proxy_) = next;
        proxy_.point = point;
        proxy_.sliding = sliding;
        // Nearer than ever before: places a rounding apart could alternate for ever.
        least_ = std::min({least_, before, after});
        return nearer ? Progress::nearer : Progress::same;
    }

    /// A proxy that rests only because it may not leave is tested once more.
    static bool settled(bool& may_leave, int& stalls) {
        if (may_leave || ++stalls > stall_limit) return true;
        may_leave = true;
        return false;
    }

    /// Stays where it is. A proxy that has not moved in this solve sticks from now on, unless its speed
    /// decides.
    void rest() {
        if (counts_.events == 1 && slip_.sticks_at_rest) proxy_.sliding = false;
    }

    void fly_to(const dvec3& point) { proxy_ = {{}, point}; }

    const Space& space_;
    Proxy& proxy_;
    const dvec3 goal_;
    const Slip& slip_;
    double least_ = std::numeric_limits<double>::infinity();  // distance to the goal so far, squared
    SolveCounts& counts_;
};

// A proxy that was stopped on the cone is inside it, whatever rounding says.
constexpr double on_the_cone = 1.0 + 2e-9;

constexpr double never_held = std::numeric_limits<double>::infinity();

/// Share (0 to 1) of the motion's way after which a sliding proxy comes to rest, if friction is level.
double sliding_share(const FrictionCone& cone, const Motion& motion) {
    if (cone.stopping == 0) return 1.0;
    const double share = 1.0 - cone.stopping * std::sqrt(motion.load2 / dot(motion.way, motion.way));
    return share > 0 ? share : 0.0;
}

/// True if a motion certainly, without a root or a division, goes on beyond `length` image steps: the share
/// of its way to there, s = length / (1 - length stretch), is less than level friction allows.
bool goes_beyond(double length, const ImageStep& step, const FrictionCone& cone, const Motion& motion) {
    constexpr double certain = 1.0 + 1e-6;  // margin far above all roundings
    const double rest = 1.0 - length * (1.0 + step.stretch), whole = rest + length;  // (1 - s) : 1
    const double held = cone.stopping * whole;
    return rest > 1e-6 && held * held * motion.load2 * certain < rest * rest * dot(motion.way, motion.way);
}

/// The friction that is missing to hold a proxy on its way from u = 0 to 1, as a cubic: held if not positive.
struct Shortfall {
    std::array<double, 4> c;

    double at(double u) const { return ((c[3] * u + c[2]) * u + c[1]) * u + c[0]; }
    double slope(double u) const { return (3 * c[3] * u + 2 * c[2]) * u + c[1]; }
    /// Bound of the roundings of a value.
    double rounding() const {
        return 0x1p-51 * (std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]) + std::abs(c[3]));
    }
    /// Sufficient: all of Bernstein's coefficients are positive.
    bool is_positive() const {
        return c[0] > 0 && 3 * c[0] + c[1] > 0 && 3 * c[0] + 2 * c[1] + c[2] > 0 &&
               c[0] + c[1] + c[2] + c[3] > 0;
    }
    /// Its turning points between 0 and 1; 1 for one elsewhere.
    std::array<double, 2> turns() const {
        std::array<double, 2> out{1, 1};
        const double discriminant = c[2] * c[2] - 3 * c[3] * c[1];
        if (!(discriminant > 0)) return out;
        const double q = -(c[2] + (c[2] < 0 ? -1.0 : 1.0) * std::sqrt(discriminant));
        const double first = c[3] == 0 ? never_held : q / (3 * c[3]), second = c[1] / q;
        if (first > 0 && first < 1) out[0] = first;
        if (second > 0 && second < 1) out[1] = second;
        return out;
    }
    /// Its zero between two places without a turning point between them: positive at `low`, not at `high`.
    /// Newton's steps, and halves if they would leave the bracket.
    double zero(double low, double high) const {
        const double near_enough = rounding();
        double u = low + (high - low) / 2;
        for (int step = 0; step < 100 && u > low && u < high; ++step) {
            const double value = at(u);
            if (std::abs(value) <= near_enough) return u;
            (value > 0 ? low : high) = u;
            const double steepness = slope(u);
            u = steepness == 0 ? low : u - value / steepness;
            if (!(u > low && u < high)) u = low + (high - low) / 2;
        }
        return high;
    }
};

/// The first u from 0 to 1 at which no shortfall is positive.
double first_held(std::span<const Shortfall> all) {
    std::array<double, 5> ends{1, 1, 1, 1, 1};  // of pieces without a turning point, in order
    bool at_once = true;
    for (const Shortfall& one : all) {
        if (one.is_positive()) return never_held;
        at_once &= one.c[0] <= 0;
        for (double turn : one.turns())
            for (double& end : ends)
                if (turn < end) std::swap(turn, end);
    }
    if (at_once) return 0;
    double low = 0;
    for (const double high : ends) {
        double first = never_held;
        for (const Shortfall& one : all) {
            if (!(one.at(low) > 0 && one.at(high) <= 0)) continue;
            const double u = one.zero(low, high);
            const bool held = std::all_of(all.begin(), all.end(), [&](const Shortfall& other) {
                return &other == &one || other.at(u) <= other.rounding();
            });
            if (held) first = std::min(first, u);
        }
        if (first <= 1) return first;
        low = high;
    }
    return never_held;
}

/// For a way of `span` image steps, by mu at the cell's corners. After L steps (1 - L (1 + t)) : (1 - L t) of
/// the way is left, and mu is quadratic in L; both times 1 - L t, and over the way's length.
Shortfall shortfall(const std::array<double, 4>& mu, double load_per_way, const ImageStep& step,
                    const CellPoint& from, double span) {
    const double da = span * step.dx, db = span * step.dy, t = span * step.stretch;
    const double along_a = mu[1] - mu[0], along_b = mu[2] - mu[0];
    const double twist = (mu[3] - mu[2]) - along_a;
    const double m0 = load_per_way * bilinear(from.a, from.b, mu[0], mu[1], mu[2], mu[3]);
    const double m1 = load_per_way * (along_a * da + along_b * db + twist * (from.a * db + from.b * da));
    const double m2 = load_per_way * (twist * da * db);
    return {{1.0 - m0, t * m0 - m1 - (span + t), t * m1 - m2, t * m2}};
}

double uneven_stop(const FrictionCone& cone, const Motion& motion, const ImageStep& step,
                   const CellPoint& from, double reach) {
    const double to_foot = step.length_at(1.0), span = std::min(reach, to_foot);
    const double way2 = dot(motion.way, motion.way);
    const double load_per_way = way2 > 0 ? std::sqrt(motion.load2 / way2) : 0.0;
    if (!(load_per_way > 0) || !(span < never_held)) return to_foot;
    if (load_per_way == std::numeric_limits<double>::infinity()) return 0;
    bool one_map = true;
    for (std::size_t k = 0; k < 4; ++k) one_map &= cone.sliding[k] <= cone.most[k];
    std::array<Shortfall, 2> lacks;
    lacks[0] = shortfall(cone.sliding, load_per_way, step, from, span);
    if (!one_map) lacks[1] = shortfall(cone.most, load_per_way, step, from, span);
    const double u = first_held({lacks.data(), one_map ? 1U : 2U});
    if (u <= 1) return u * span;
    return span == to_foot ? to_foot : never_held;
}

}  // namespace

Motion project_on_tangent_cone(const auto& space, const Proxy& proxy, const dvec3& point, const dvec3& pull,
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

template <class Space>
[[gnu::noinline]] void slide(const Space& space, Proxy& proxy, const dvec3& goal, const SolveLimits& limits,
                             const Slip& slip, SolveCounts& counts) {
    Slide<Space>(space, proxy, goal, slip, counts).run(limits);
}

template void slide(const WorldSpace&, Proxy&, const dvec3&, const SolveLimits&, const Slip&, SolveCounts&);
template void slide(const PixelSpace&, Proxy&, const dvec3&, const SolveLimits&, const Slip&, SolveCounts&);

Slip stribeck_slip(double speed, double stribeck_speed) {
    const double ratio = speed / stribeck_speed;
    return {1.0 / (1.0 + ratio * ratio), false};
}

bool is_slow(double speed, double stribeck_speed) {
    return speed < 0.1 * stribeck_speed;
}

FrictionCone cone_over(const CornerProperties& corners, const CellPoint& at, bool sliding, const Slip& slip) {
    FrictionCone cone;
    for (std::size_t k = 0; k < 4; ++k) {
        const double mu_d = corners[k].dynamic_friction, mu_s = corners[k].static_friction;
        cone.sliding[k] = mu_d + slip.static_share * (mu_s - mu_d);
        cone.most[k] = mu_s;
        cone.level &= cone.sliding[k] == cone.sliding[0] && mu_s == cone.most[0];
    }
    const auto here = [&at](const std::array<double, 4>& mu) {
        return bilinear(at.a, at.b, mu[0], mu[1], mu[2], mu[3]);
    };
    const double mu_s = here(cone.most);
    cone.stopping = std::min(here(cone.sliding), mu_s);
    cone.resting = sliding ? cone.stopping : mu_s;
    return cone;
}

bool rests(const FrictionCone& cone, const Motion& motion) {
    const double mu2 = cone.resting * cone.resting;
    return mu2 > 0 && dot(motion.way, motion.way) <= mu2 * motion.load2 * on_the_cone;
}

double stopping_length(const FrictionCone& cone, const Motion& motion, const ImageStep& step,
                       const CellPoint& from, double reach) {
    if (!cone.level) return uneven_stop(cone, motion, step, from, reach);
    if (goes_beyond(reach, step, cone, motion)) return never_held;
    return step.length_at(sliding_share(cone, motion));
}

}  // namespace touchable
