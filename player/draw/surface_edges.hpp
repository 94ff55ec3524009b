#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/base/vector_unit.hpp"
#include "shaders/cut_rule.h"
#include "shaders/edge_rule.h"

namespace touchable {

/// The vertices of a lattice that are not drawn at their pixel (shaders/edge_rule.h), found by the CPU: the
/// same with any number of threads and any vectors. A view that is the clip's own is drawn without them.
class SurfaceEdges {
public:
    struct Vertex {
        std::int32_t x;
        float at_x, at_y, q;  ///< where it is drawn, pixels
        float light;          ///< how much of its colour, 0 to 1
    };

    explicit SurfaceEdges(int threads, VectorUnit vectors = usable_vector_units().front());

    /// Of q in rows of `pitch`; 0 is no surface. `are_values`: colours are those of a scale, and are not
    /// shaded.
    void find(const float* q, int width, int height, int pitch, float cut_ratio = CUT_RULE_RATIO,
              bool are_values = false);
    /// None any more.
    void clear() { rows_.clear(); }

    /// Those of a row, from left to right.
    std::span<const Vertex> row(int y) const;
    /// One of them, or null where the vertex is drawn at its pixel.
    const Vertex* at(int x, int y) const;

private:
    /// Of a thread: which pairs of neighbours are one surface, -1 or 0, for two rows of cells.
    struct Scratch {
        std::vector<std::int32_t> right, down, aslant, upper_down, upper_aslant, candidates;
    };
    void find_rows(const EdgeLattice& lattice, bool are_values, const RowBand& band);

    VectorUnit unit_;
    RowBands bands_;
    std::vector<Scratch> scratch_;
    std::vector<std::vector<Vertex>> rows_;
};

}  // namespace touchable
