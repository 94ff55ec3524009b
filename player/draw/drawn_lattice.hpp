#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "shaders/cut_rule.h"
#include "shaders/edge_rule.h"

namespace touchable {

/// The lattice of a field as painters draw it, vertex by vertex, for whoever needs few of them: looked up
/// when asked for, and kept for a while.
class DrawnLattice {
public:
    /// `is_turned`: as every view but the clip's own has it. There shaders/edge_rule.h says where vertices at
    /// edges are, and depth steps are cut; in the clip's own all are at their pixels, and holes alone are
    /// cut.
    DrawnLattice(const HeightField& field, bool is_turned);

    struct Triangle {
        std::array<glm::dvec3, 3> corners;  ///< (x, y, q) where they are drawn
        bool cut;                           ///< it is not drawn (shaders/cut_rule.h)
        bool moved;                         ///< a corner is not at its pixel
    };
    /// Of cell (i, j): the one to the right of the diagonal from its first corner, or the one below it.
    Triangle triangle(int i, int j, bool right);
    /// Whether what is drawn over a cell may be a triangle of another one.
    bool is_near_edges(int i, int j);

    // As shaders/edge_rule.h asks for a lattice.
    const int width, height;
    const float ratio = CUT_RULE_RATIO;
    friend float edge_q(const DrawnLattice& lattice, const glm::ivec2& at) { return lattice.vertex(at).q; }

private:
    struct Vertex {
        int x = -1, y = -1;
        double exact_q = 0;
        float q = 0;  ///< 0: invalid
    };
    struct Edge {
        int x = -1, y = -1;
        bool is_moved = false;
        glm::dvec3 place{0.0};
    };
    static constexpr int side = 32;  ///< of the lattice's part that is kept: a way goes through it once
    static std::size_t slot(int x, int y) {
        return static_cast<std::size_t>(y % side) * side + static_cast<std::size_t>(x % side);
    }
    const Vertex& vertex(const glm::ivec2& at) const;
    const Edge& edge(int x, int y);

    const HeightField& field_;
    const bool is_turned_;
    mutable std::vector<Vertex> vertices_;
    std::vector<Edge> edges_;
};

}  // namespace touchable
