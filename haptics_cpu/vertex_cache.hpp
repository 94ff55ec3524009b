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
    template <class Compute>
    const SpaceVertex& at(std::int64_t i, std::int64_t j, Compute compute) {
        Entry& entry = entries_[static_cast<std::size_t>((i & 3) | ((j & 3) << 2))];
        if (entry.i != i || entry.j != j) entry = {i, j, compute()};
        return entry.vertex;
    }

private:
    struct Entry {
        std::int64_t i = std::numeric_limits<std::int64_t>::min(), j = 0;
        SpaceVertex vertex;  // not written before its place is
    };
    std::array<Entry, 16> entries_;
};

}  // namespace touchable
