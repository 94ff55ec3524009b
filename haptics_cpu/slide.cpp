#include "haptics_cpu/slide.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "haptics_cpu/cast.hpp"
#include "haptics_cpu/friction.hpp"
#include "haptics_cpu/pixel_space.hpp"
#include "haptics_cpu/surface_lattice.hpp"
#include "haptics_cpu/tangent_cone.hpp"
#include "haptics_cpu/world_space.hpp"

namespace touchable {

namespace {

using glm::dvec3;

/// Which edges of a face a move starts on; it does not leave through them, whatever rounding says.
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

/// A place a rounding beside the rim of its face or edge is on the rim, where other faces have a say.
Place on_the_rim(const Place& at) {
    const auto snapped = [](double f) { return f < 0x1p-48 ? 0.0 : (f > 1 - 0x1p-48 ? 1.0 : f); };
    const double a = snapped(at.a), b = snapped(at.b);
    if (at.feature == Feature::edge_v) return edge_place(at.feature, at.i, at.j, b);
    if (at.feature == Feature::edge_h || at.feature == Feature::edge_d)
        return edge_place(at.feature, at.i, at.j, a);
    if (at.feature == Feature::face_lower || at.feature == Feature::face_upper)
        return face_or_rim_place(at.feature, at.i, at.j, a, std::abs(a - b) < 0x1p-48 ? a : b);
    return at;
}

/// The distance to the goal is the same after such a way: it is gone whole, whatever friction says, which
/// could end ever shorter ones and never let it arrive.
bool too_short_to_tell(const Motion& motion, const dvec3& pull) {
    return glm::dot(motion.way, motion.way) <= 0x1p-52 * glm::dot(pull, pull);
}

/// A way that is made of roundings. A proxy that may not leave would go to and fro on such.
bool is_rounding(const Motion& motion, const dvec3& pull) {
    return glm::dot(motion.way, motion.way) <= 0x1p-96 * glm::dot(pull, pull);
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
                // Held back by friction, the place may have another cone than the start: look again.
                const bool whole = stalls > 0 && too_short_to_tell(motion, pull);
                arrived = move(motion, whole ? no_friction : cone, next) && cone.stopping == 0;
                if (whole) {
                    next = on_the_rim(next);
                    arrived &= next.feature == motion.feature;
                }
                // Also where there is no friction yet: what was in motion is, where it meets some.
                sliding = space_.field().has_friction();
            }
            const Progress progress = take(next, sliding, pull);
            if (progress == Progress::nearer) {
                if (arrived && may_leave && is_foot(motion, pull)) return;
                stalls = 0;
                may_leave = true;  // also where it had to stay, and came to its foot on the surface
                continue;
            }
            // Rounding can make a flight off the surface end where it began, or a step end on the other side
            // of an edge at the same distance. Go on along the surface, a few times on end at most.
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

    /// True if it went all the way that friction leaves it and is inside the face: on the rim the other side
    /// has its say too.
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
        if (exit.edge == Feature::free) {  // no way out and none to go: a motion of no length
            to = proxy_;
            return true;
        }
        to = rim_place(motion, step, from, exit);
        return false;
    }

    /// True if it went all the way that friction leaves it.
    bool move_along_edge(const Motion& motion, const ImageStep& step, const FrictionCone& cone,
                         Place& to) const {
        const bool vertical = motion.feature == Feature::edge_v;
        const CellPoint from = in_cell_of(motion, proxy_);
        const double start = vertical ? from.b : from.a, speed = vertical ? step.dy : step.dx;
        // An edge so steep that its image stands still ends nowhere in it.
        const double reach = speed == 0 ? std::numeric_limits<double>::infinity()
                                        : (speed > 0 ? 1.0 - start : start) / std::abs(speed);
        // What roundings add across the edge is no way.
        const ImageStep along{vertical ? 0.0 : speed, motion.feature == Feature::edge_h ? 0.0 : speed,
                              step.stretch};
        const double length = stopping_length(cone, motion, along, from, reach);
        const double end = length < reach ? start + length * speed : (speed > 0 ? 1.0 : 0.0);
        to = edge_place(motion.feature, motion.i, motion.j, speed == 0 ? start : end);
        return to.feature != Feature::vertex;
    }

    /// The place that was taken is where the way ended, as far as the force that is left can tell. On a face
    /// seen edge-on by a billionth of its depth the image of a way is known to few digits, and a way that is
    /// long beside what is left of the pull ends where its own roundings put it: there it is gone once more
    /// from where it led.
    bool is_foot(const Motion& motion, const dvec3& pull) const {
        const dvec3 left = goal_ - proxy_.point, aside = left - (pull - motion.way);
        return glm::dot(aside, aside) <= 1e-20 * glm::dot(left, left);
    }

    enum class Progress { nearer, same, none };

    /// How far the roundings of its w move a place: far, where a cell reaches from near the camera to far
    /// away.
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

    /// Whether it is certain that a place is nearer to the goal, where squares of the distance cannot tell:
    /// of a goal a billion units away they are the same all over the picture. Before^2 - after^2 is the step
    /// times the sum of both pulls; of the step the roundings of its ends are not known.
    bool is_surely_nearer(const dvec3& point, const dvec3& pull, const dvec3& rest) const {
        const dvec3 both = pull + rest;
        const double ends = glm::length(point) + glm::length(proxy_.point);
        return glm::dot(point - proxy_.point, both) > 0x1p-48 * ends * glm::length(both);
    }

    /// Takes the new place unless it is farther from the goal than rounding explains.
    Progress take(const Place& next, bool sliding, const dvec3& pull) {
        const dvec3 point = surface_point(space_, next);
        const dvec3 rest = goal_ - point;
        const double before = glm::dot(pull, pull), after = glm::dot(rest, rest);
        if (!(after <= before * (1.0 + 1e-13)) &&
            !is_explained(std::sqrt(before), std::sqrt(after), next, point))
            return Progress::none;
        const bool nearer = after < std::min(least_, before) || is_surely_nearer(point, pull, rest);
        static_cast<Place&>(proxy_) = next;
        proxy_.point = point;
        proxy_.sliding = sliding;
        // Nearer than it ever was: places a rounding apart could take turns for ever.
        least_ = std::min({least_, before, after});
        return nearer ? Progress::nearer : Progress::same;
    }

    /// A proxy that rests only because it may not leave is asked once more.
    static bool settled(bool& may_leave, int& stalls) {
        if (may_leave || ++stalls > stall_limit) return true;
        may_leave = true;
        return false;
    }

    /// Stays where it is. A proxy that had not moved at all in this solve sticks from now on, unless its
    /// speed has the say.
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

}  // namespace

template <class Space>
void slide(const Space& space, Proxy& proxy, const dvec3& goal, const SolveLimits& limits, const Slip& slip,
           SolveCounts& counts) {
    Slide<Space>(space, proxy, goal, slip, counts).run(limits);
}

template void slide(const WorldSpace&, Proxy&, const dvec3&, const SolveLimits&, const Slip&, SolveCounts&);
template void slide(const PixelSpace&, Proxy&, const dvec3&, const SolveLimits&, const Slip&, SolveCounts&);

}  // namespace touchable
