#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

namespace touchable {

/// A lattice vertex where distances are measured, and its height in the chart (larger is nearer to the
/// camera).
struct SpaceVertex {
    glm::dvec3 position;
    double w;
    bool valid;  ///< false: an invalid pixel or the ring
};

/// The vertices of a tick that were computed last: a slide passes from cell to cell, and each cell brings one
/// new vertex. Direct-mapped by the low bits of (i, j). For one thread.
class VertexCache {
public:
    VertexCache() { i_.fill(std::numeric_limits<std::int64_t>::min()); }
    template <class Compute>
    const SpaceVertex& at(std::int64_t i, std::int64_t j, Compute compute) {
        const std::size_t entry = entry_of(i, j);
        if (!holds(entry, i, j)) {
            vertices_[entry] = compute();
            i_[entry] = i;
            j_[entry] = j;
        }
        return vertices_[entry];
    }
    /// Null for one that it does not hold.
    const SpaceVertex* find(std::int64_t i, std::int64_t j) const {
        const std::size_t entry = entry_of(i, j);
        return holds(entry, i, j) ? &vertices_[entry] : nullptr;
    }

private:
    static std::size_t entry_of(std::int64_t i, std::int64_t j) {
        return static_cast<std::size_t>((i & 3) | ((j & 3) << 2));
    }
    bool holds(std::size_t entry, std::int64_t i, std::int64_t j) const {
        return i_[entry] == i && j_[entry] == j;
    }
    // Places beside the vertices, so that a tick begins by clearing 16 numbers; of an entry without a vertex
    // only i is written.
    std::array<std::int64_t, 16> i_, j_;
    std::array<SpaceVertex, 16> vertices_;
};

}  // namespace touchable
