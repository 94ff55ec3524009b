#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "player/draw/view_surface.hpp"

namespace touchable {

/// A lattice in the CPU's memory: rows of `pitch` vertices.
struct MappedLattice {
    const float* q;
    const PackedColour* colours;
    int width, height, pitch;
    int step = 1;  ///< of the clip's pixels, from vertex to vertex (Decimation)
};

/// A row of vertices on the screen. Colours are times share, 1 / w.
struct LatticeRow {
    void resize(std::size_t vertices) {
        for (auto* each : {&x, &y, &in_front}) each->resize(vertices);
        for (auto* each : {&q, &z, &share, &red, &green, &blue}) each->resize(vertices);
        colours.resize(vertices);
    }
    std::vector<std::int32_t> x, y;      ///< subpixels
    std::vector<std::int32_t> in_front;  ///< -1 where it is not before the near plane, otherwise 0
    std::vector<float> q, z, share, red, green, blue;
    std::vector<PackedColour> colours;
    std::int32_t least_y = 0, most_y = 0;  ///< of what is there
    bool is_in_front = false;              ///< all of it
};

}  // namespace touchable
