#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "engine/scene/plane_view.hpp"
#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// A colour of 8 bits a channel: red in the lowest byte, then green and blue; the highest is 255.
using PackedColour = std::uint32_t;
constexpr PackedColour pack_colour(std::uint32_t r, std::uint32_t g, std::uint32_t b) {
    return r | g << 8 | b << 16 | 255U << 24;
}

/// Tiles of TileGrid worth drawing, as row * tiles_x + column, ascending.
struct ViewTiles {
    std::vector<std::uint32_t> whole;  ///< no triangle in them is cut (shaders/cut_rule.h)
    std::vector<std::uint32_t>
        mixed;  ///< some are; there is one without a hole, which the clip's own view shows
    bool operator==(const ViewTiles&) const = default;
};

struct GpuLattice;  // gpu_lattice.hpp

/// What a painter draws: the lattice at one moment, with a colour at every vertex.
struct ViewSurface {
    int width = 0, height = 0;
    std::vector<float> q;               ///< 1 / planar depth, height taken off; 0: invalid. Row-major
    std::vector<PackedColour> colours;  ///< row-major
    bool colours_are_values = false;    ///< of a scale: nothing may darken them
    ViewTiles tiles;
    std::shared_ptr<const GpuLattice> on_gpu;  ///< q and tiles once more, where they were made on a GPU

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

/// q of every pixel of a field: of what is drawn there (drawn_vertex.hpp), to the nearest float.
std::vector<float> q_of(const HeightField& field);

/// The surface of a field with these q and tiles. Colours are those of `colour` (3 channels of the field's
/// size), gently lit; where that is empty, light and depth alone.
ViewSurface make_view_surface(const HeightField& field, std::vector<float> q, ViewTiles tiles,
                              const PlaneView& colour);

/// What there is to look at, world: a hundred thousand points at most of the valid pixels that are not at the
/// far plane, where backgrounds are, and the lower medians of their X, Y and Z. Without any, the middle is
/// the point at the far plane on the optical axis.
struct Subject {
    glm::dvec3 middle{0.0};
    std::vector<glm::dvec3> points;
};
Subject subject_of(const HeightField& field);

}  // namespace touchable
