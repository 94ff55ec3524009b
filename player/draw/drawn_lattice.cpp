#include "player/draw/drawn_lattice.hpp"

#include <algorithm>
#include <cstddef>

#include "player/draw/drawn_vertex.hpp"

namespace touchable {

DrawnLattice::DrawnLattice(const HeightField& field, bool is_turned)
    : width(field.width()),
      height(field.height()),
      field_(field),
      is_turned_(is_turned),
      vertices_(side * side),
      edges_(is_turned ? side * side : 0) {}

const DrawnLattice::Vertex& DrawnLattice::vertex(const glm::ivec2& at) const {
    Vertex& kept = vertices_[slot(at.x, at.y)];
    if (kept.x == at.x && kept.y == at.y) return kept;
    const Scene& scene = field_.scene();
    const FieldVertex found = drawn_vertex(field_, at.x, at.y);
    const double q = 1 / planar_depth(scene.camera, scene.depth.semantics, at.x, at.y, found.depth);
    kept = {at.x, at.y, q, found.valid ? static_cast<float>(q) : 0.0F};
    return kept;
}

const DrawnLattice::Edge& DrawnLattice::edge(int x, int y) {
    Edge& kept = edges_[slot(x, y)];
    if (kept.x == x && kept.y == y) return kept;
    const EdgeMove move = edge_move(*this, ivec2(x, y));
    constexpr double step = 1.0 / EDGE_UNIT;
    kept = {x, y, move.by != ivec2(0, 0) || move.q != vertex({x, y}).q,
            glm::dvec3(x + step * move.by.x, y + step * move.by.y, move.q)};
    return kept;
}

DrawnLattice::Triangle DrawnLattice::triangle(int i, int j, bool right) {
    const std::array<ivec2, 3> at{{{i, j}, {i + 1, right ? j : j + 1}, {right ? i + 1 : i, j + 1}}};
    Triangle out{};
    std::array<float, 3> q;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vertex& here = vertex(at[k]);
        q[k] = here.q;
        out.corners[k] = {at[k].x, at[k].y, here.exact_q};
    }
    out.cut = is_turned_ ? triangle_is_cut(q[0], q[1], q[2]) : triangle_has_hole(q[0], q[1], q[2]);
    if (!is_turned_ || out.cut) return out;
    for (std::size_t k = 0; k < 3; ++k) {
        const Edge& there = edge(at[k].x, at[k].y);
        if (!there.is_moved) continue;
        out.moved = true;
        out.corners[k] = there.place;
    }
    return out;
}

bool DrawnLattice::is_near_edges(int i, int j) {
    if (!is_turned_) return false;
    for (int y = std::max(j - 1, 0); y <= std::min(j + 2, height - 1); ++y)
        for (int x = std::max(i - 1, 0); x <= std::min(i + 2, width - 1); ++x)
            if (edge(x, y).is_moved) return true;
    return false;
}

}  // namespace touchable
