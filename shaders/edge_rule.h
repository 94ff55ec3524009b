// SPDX-License-Identifier: Apache-2.0
// Moves vertices at edges. Compiled as GLSL and as C++: every painter moves them alike.
//
// Where cut_rule.h leaves out triangles, surfaces end at pixels, which looks like a saw from the side. The
// edge's course tells where between two pixels it is: from a vertex beside a gap the edge is followed by up
// to EDGE_REACH vertices to either side, equally far both ways and not around corners. Their mean is the
// edge's place, in whole steps of EDGE_UNIT; the surface's pixels end half a pixel beyond.
//
// A vertex moves only out into the gap, along a column or a row, by less than a pixel. Then no triangle turns
// over: neighbours of one surface never move towards each other. In a corner that the surface has around a
// gap a vertex moves diagonally, to the middle of its two neighbours beside the gap, and is drawn with their
// mean: otherwise each step of an edge would be a tooth.
//
// q at an edge continues the surface within: at the edge a camera mixes foreground and background, and a
// surface that curves away ends in steps as high as it is steep. q of a plane is linear in x and y. So it is
// extrapolated from the two vertices within, by the mean of those along the edge.
//
// A surface that falls away steeply at an edge is a streak from the side, in colours that a camera saw at a
// grazing angle or mixed, with teeth as long as its steps are high. Up to EDGE_ERODED vertices from a gap it
// is eroded where it is too steep, and ends between two vertices where it becomes so. What lies behind an
// edge loses one vertex, in which cameras mix near and far. Touch has all of them.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_EDGE_RULE_H
#define TOUCHABLE_SHADERS_EDGE_RULE_H

#ifdef __cplusplus
#include <glm/vec2.hpp>
namespace touchable {
using glm::ivec2;
#define EDGE_FUNCTION template <class Lattice>
#define EDGE_LATTICE const Lattice&
#define EDGE_CHANGED(type) type&
#define EDGE_PRECISE
#else
#define EDGE_FUNCTION
#define EDGE_LATTICE EdgeLattice
#define EDGE_CHANGED(type) inout type
#define EDGE_PRECISE precise
#endif

#define EDGE_REACH 4         // vertices to either side
#define EDGE_UNIT 128        // steps of a pixel
#define EDGE_MOST 96         // steps of a move
#define EDGE_MOST_STEEP 121  // of a move towards an eroded vertex
#define EDGE_ERODED 2        // vertices from a gap

/// Rows of q, 0 where there is no surface. (In C++ any lattice with an `edge_q` works.)
struct EdgeLattice {
#ifdef __cplusplus
    const float* q;
#endif
    int width, height;
    int pitch;       // vertices from one row of q to the next
    float ratio;     // of cut_rule.h
    float steepest;  // change of q per vertex, relative to q, that is drawn beside a gap
};

/// Where a vertex is drawn: its offset from its pixel, in steps of EDGE_UNIT, and its q there.
struct EdgeMove {
    ivec2 by;
    float q;
};

#ifdef __cplusplus
inline float edge_q(const EdgeLattice& lattice, const ivec2& at) {
    return lattice.q[static_cast<long>(at.y) * lattice.pitch + at.x];
}
#else
float edge_q(EdgeLattice lattice, ivec2 at);
#endif

EDGE_FUNCTION bool edge_is_there(EDGE_LATTICE lattice, ivec2 at) {
    return at.x >= 0 && at.y >= 0 && at.x < lattice.width && at.y < lattice.height;
}

/// Whether neighbours with these q are of one surface.
EDGE_FUNCTION bool edge_are_near(EDGE_LATTICE lattice, float a, float b) {
    const float least = a < b ? a : b, greatest = a < b ? b : a;
    return least > 0.0f && greatest <= lattice.ratio * least;
}

/// Whether two neighbours are of one surface, and none is eroded.
EDGE_FUNCTION bool edge_joins(EDGE_LATTICE lattice, ivec2 one, ivec2 other) {
    return edge_are_near(lattice, edge_q(lattice, one), edge_q(lattice, other));
}

/// q without erosion.
EDGE_FUNCTION float edge_whole_q(EDGE_LATTICE lattice, ivec2 at) {
    const float q = edge_q(lattice, at);
    return q < 0.0f ? -q : q;
}

/// Whether there is a gap between a vertex and its neighbour `beside` in the picture.
EDGE_FUNCTION bool edge_has_gap(EDGE_LATTICE lattice, ivec2 at, ivec2 beside) {
    return edge_is_there(lattice, beside) && !edge_joins(lattice, at, beside);
}

/// Moves `at` from a vertex with a gap towards `out_` to the next along it; false if the edge ends or turns.
EDGE_FUNCTION bool edge_goes_on(EDGE_LATTICE lattice, EDGE_CHANGED(ivec2) at, ivec2 along, ivec2 out_) {
    ivec2 next = at + along;
    if (!edge_is_there(lattice, next)) return false;
    if (edge_joins(lattice, at, next)) {
        const ivec2 farther = next + out_;
        if (!edge_is_there(lattice, farther)) return false;
        if (edge_joins(lattice, next, farther)) next = farther;
    } else {
        next = next - out_;
        if (!edge_is_there(lattice, next) || !edge_joins(lattice, at, next)) return false;
    }
    at = next;
    return edge_has_gap(lattice, next, next + out_);
}

/// Adds q of the surface within, extrapolated to a vertex at its edge, and its change per vertex outwards;
/// false if the surface is too narrow to tell.
EDGE_FUNCTION bool edge_slope(EDGE_LATTICE lattice, ivec2 at, ivec2 out_, EDGE_CHANGED(float) q,
                              EDGE_CHANGED(float) change) {
    const ivec2 within = at - out_, farther = within - out_;
    if (!edge_is_there(lattice, farther) || !edge_joins(lattice, at, within) ||
        !edge_joins(lattice, within, farther))
        return false;
    const float here = edge_q(lattice, within);
    EDGE_PRECISE float step = here - edge_q(lattice, farther);
    EDGE_PRECISE float sum = q + (here + step);
    EDGE_PRECISE float changes = change + step;
    q = sum;
    change = changes;
    return true;
}

/// How steep the surface is at a vertex: the square of q's change per vertex, of the less steep sides, which
/// are within a surface that ends here.
EDGE_FUNCTION float edge_steepness(EDGE_LATTICE lattice, ivec2 at) {
    const float here = edge_whole_q(lattice, at);
    EDGE_PRECISE float squares = 0.0f;
    for (int axis = 0; axis < 2; ++axis) {
        const ivec2 along = ivec2(1 - axis, axis);
        float least = 0.0f;
        bool is_one = false;
        for (int side = -1; side <= 1; side += 2) {
            const ivec2 beside = at + side * along;
            if (!edge_is_there(lattice, beside)) continue;
            const float there = edge_whole_q(lattice, beside);
            if (!edge_are_near(lattice, here, there)) continue;
            const float apart = here < there ? there - here : here - there;
            least = is_one && least < apart ? least : apart;
            is_one = true;
        }
        EDGE_PRECISE float square = least * least;
        squares = squares + square;
    }
    return squares;
}

/// The greatest steepness that is drawn beside a gap.
EDGE_FUNCTION float edge_steepest(EDGE_LATTICE lattice, float here) {
    EDGE_PRECISE float change = lattice.steepest * here;
    EDGE_PRECISE float square = change * change;
    return square;
}

/// q of a vertex as edges are found from it: negative if the vertex is eroded.
EDGE_FUNCTION float edge_eroded_q(EDGE_LATTICE lattice, ivec2 at) {
    const float here = edge_whole_q(lattice, at);
    if (!(here > 0.0f)) return here;
    const bool is_steep = edge_steepness(lattice, at) > edge_steepest(lattice, here);
    for (int side = 0; side < 4; ++side) {
        const ivec2 out_ = side < 2 ? ivec2(2 * side - 1, 0) : ivec2(0, 2 * side - 5);
        ivec2 last = at;
        for (int n = 0; n < EDGE_ERODED; ++n) {
            const ivec2 next = last + out_;
            if (!edge_is_there(lattice, next)) break;
            const float one = edge_whole_q(lattice, last), other = edge_whole_q(lattice, next);
            if (!edge_are_near(lattice, one, other)) {
                if (is_steep || (n == 0 && other > one)) return -here;
                break;
            }
            if (!is_steep) break;
            last = next;
        }
    }
    return here;
}

/// Moves a vertex towards `out_`, to where the surface becomes too steep: a ball's 1 / steepness is linear
/// there. False if it ends for another reason.
EDGE_FUNCTION bool edge_to_steep(EDGE_LATTICE lattice, ivec2 at, ivec2 out_, EDGE_CHANGED(EdgeMove) move) {
    const float beside = -edge_q(lattice, at + out_);
    const bool is_eroded = edge_are_near(lattice, edge_q(lattice, at), beside);
    // Between the vertex and its eroded neighbour, or beyond the vertex by what it is beside the one within.
    const ivec2 from = is_eroded ? at : at - out_, to = from + out_;
    if (!edge_is_there(lattice, from)) return false;
    const float here = edge_q(lattice, from), there = edge_whole_q(lattice, to);
    if (!edge_are_near(lattice, here, there)) return false;
    const float flat_ = edge_steepness(lattice, from), steep = edge_steepness(lattice, to),
                most = edge_steepest(lattice, here);
    // Without an eroded neighbour only what steepens as a ball does has a limb; a last pixel in which near and
    // far are mixed has none.
    const bool is_limb = is_eroded ? steep > edge_steepest(lattice, there)
                                   : steep > 0.25f * most && steep > 1.25f * flat_ && steep < 4.0f * flat_;
    if (!is_limb) return false;
    // Without division: the same on every machine.
    EDGE_PRECISE float both = flat_ * steep;
    const int first = is_eroded ? 0 : EDGE_UNIT;
    int steps = 0;
    for (int half_of = EDGE_UNIT / 2; half_of > 0; half_of /= 2) {
        const float share = float(first + steps + half_of) / float(EDGE_UNIT);
        EDGE_PRECISE float mean = flat_ + (1.0f - share) * (steep - flat_);
        EDGE_PRECISE float reached = most * mean;
        if (steps + half_of <= EDGE_MOST_STEEP && reached >= both) steps += half_of;
    }
    if (!is_eroded && steps == EDGE_MOST_STEEP) return false;
    move.by = steps * out_;
    EDGE_PRECISE float q = here + (float(first + steps) / float(EDGE_UNIT)) * (there - here);
    move.q = q;
    return true;
}

/// The move of a vertex with a gap on one side, `out_`; returns how far its edge was followed.
EDGE_FUNCTION int edge_across(EDGE_LATTICE lattice, ivec2 at, ivec2 out_, EDGE_CHANGED(EdgeMove) move) {
    const float shares[EDGE_REACH + 1] = {1.0f, 1.0f / 3.0f, 1.0f / 5.0f, 1.0f / 7.0f, 1.0f / 9.0f};
    const ivec2 along = ivec2(out_.y, out_.x);
    ivec2 left = at, right = at;
    float q = 0.0f, change = 0.0f;
    int reach = 0, beyond = 0;
    const bool is_wide = edge_slope(lattice, at, out_, q, change);
    while (reach < EDGE_REACH) {
        if (!edge_goes_on(lattice, left, -along, out_) || !edge_goes_on(lattice, right, along, out_)) break;
        float sum = q, changes = change;
        if (is_wide && (!edge_slope(lattice, left, out_, sum, changes) ||
                        !edge_slope(lattice, right, out_, sum, changes)))
            break;
        q = sum;
        change = changes;
        const ivec2 both = (left - at) + (right - at);
        beyond += both.x * out_.x + both.y * out_.y;
        ++reach;
    }
    if (edge_to_steep(lattice, at, out_, move)) return reach;
    // The mean, made positive to be rounded down; half a pixel farther.
    const int count = 2 * reach + 1;
    int steps = (EDGE_UNIT * (beyond + EDGE_REACH * count)) / count - EDGE_UNIT * EDGE_REACH + EDGE_UNIT / 2;
    steps = steps < 0 ? 0 : (steps > EDGE_MOST ? EDGE_MOST : steps);
    move.by = steps * out_;
    move.q = edge_q(lattice, at);
    if (!is_wide) return reach;
    const float within = edge_q(lattice, at - out_);
    EDGE_PRECISE float mean = q * shares[reach];
    EDGE_PRECISE float slope = change * shares[reach];
    EDGE_PRECISE float here = mean + 0.5f * slope;
    // q differs from that within by at most half of what neighbours of one surface may: steeper ones would
    // end in long tongues.
    EDGE_PRECISE float apart = (0.5f * (lattice.ratio - 1.0f)) * within;
    EDGE_PRECISE float least = within - apart;
    EDGE_PRECISE float most = within + apart;
    move.q = here < least ? least : (here > most ? most : here);
    return reach;
}

/// The move of a vertex with a gap towards `out_`, by its move there and how far its edge was followed: on
/// the side along which the edge goes farther.
EDGE_FUNCTION EdgeMove edge_farther(EDGE_LATTICE lattice, ivec2 at, ivec2 out_, EdgeMove move, int reach) {
    const ivec2 side = ivec2(out_.y, out_.x);
    const bool gap_after = edge_has_gap(lattice, at, at + side),
               gap_before = edge_has_gap(lattice, at, at - side);
    if (gap_after == gap_before) return move;
    EdgeMove other = move;
    const int other_reach = edge_across(lattice, at, gap_after ? side : -side, other);
    const bool is_farther = out_.y != 0 ? reach >= other_reach : reach > other_reach;
    if (is_farther && !edge_has_gap(lattice, at, at - out_)) return move;
    return other;
}

/// Where a vertex is drawn. `lattice` has two columns and two rows at least.
EDGE_FUNCTION EdgeMove edge_move(EDGE_LATTICE lattice, ivec2 at) {
    EdgeMove move;
    move.by = ivec2(0, 0);
    move.q = edge_q(lattice, at);
    if (!(move.q > 0.0f)) return move;
    const ivec2 right = ivec2(1, 0), down = ivec2(0, 1);
    const bool gap_right = edge_has_gap(lattice, at, at + right),
               gap_left = edge_has_gap(lattice, at, at - right),
               gap_down = edge_has_gap(lattice, at, at + down), gap_up = edge_has_gap(lattice, at, at - down);
    const bool across = gap_right != gap_left, upright = gap_down != gap_up;
    if (across || upright) {
        EdgeMove level = move, steep = move;
        const int level_reach = across ? edge_across(lattice, at, gap_right ? right : -right, level) : -1;
        const int steep_reach = upright ? edge_across(lattice, at, gap_down ? down : -down, steep) : -1;
        return steep_reach >= level_reach ? steep : level;
    }
    if (gap_right || gap_down) return move;  // on both sides
    const ivec2 aslant = ivec2(1, 1);
    const bool gap_after = edge_has_gap(lattice, at, at + aslant),
               gap_before = edge_has_gap(lattice, at, at - aslant);
    if (gap_after == gap_before) return move;
    const ivec2 out_ = gap_after ? aslant : -aslant;
    const ivec2 beyond = at + out_, one = ivec2(beyond.x, at.y), other = ivec2(at.x, beyond.y);
    if (edge_joins(lattice, beyond, one) || edge_joins(lattice, beyond, other)) return move;
    // In the middle of where the two neighbours beside the gap would go.
    EdgeMove level = move, steep = move;
    const ivec2 out_one = ivec2(0, out_.y), out_other = ivec2(out_.x, 0);
    const int reach_one = edge_across(lattice, one, out_one, level),
              reach_other = edge_across(lattice, other, out_other, steep);
    const int steps = (2 * EDGE_UNIT + out_.y * level.by.y + out_.x * steep.by.x) / 4;
    move.by = steps * out_;
    const EdgeMove drawn_one = edge_farther(lattice, one, out_one, level, reach_one),
                   drawn_other = edge_farther(lattice, other, out_other, steep, reach_other);
    EDGE_PRECISE float sum = drawn_one.q + drawn_other.q;
    move.q = 0.5f * sum;
    return move;
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef EDGE_FUNCTION
#undef EDGE_LATTICE
#undef EDGE_CHANGED
#undef EDGE_PRECISE

#endif
