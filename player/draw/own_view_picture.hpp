#pragma once

#include <span>
#include <vector>

#include "engine/base/vector_unit.hpp"
#include "player/draw/lattice_row.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// The surface as the clip's own camera sees it, drawn by the CPU. From there a vertex is seen where it is
/// whatever its depth: columns and rows of the lattice are upright and level on the screen. So the cell, the
/// triangle and the place in it that a pixel shows follow from its column and its row alone.
class OwnViewPicture {
public:
    explicit OwnViewPicture(VectorUnit vectors = usable_vector_units().front()) : unit_(vectors) {}

    /// Whether a camera is the clip's own, with cells no larger than `raster` draws (RASTER_LARGE_CELL).
    static bool draws(const ViewCamera& camera);

    /// Writes colours and z (as the other painters have it: 0 is empty) of the camera's pixels, rows of
    /// `pitch`. `background`: a colour for each row.
    void draw(const MappedLattice& lattice, const ViewCamera& camera,
              std::span<const PackedColour> background, int pitch, std::span<PackedColour> colours,
              std::span<float> z);

private:
    /// Of each pixel along one side of the picture: the cell before it, and how far it is into that, 0 to 1.
    struct Places {
        int first = 0, end = 0;  ///< pixels that are in any
        std::vector<int> cells;
        std::vector<float> into;
    };
    /// Vertices of a row of the lattice, at each column of the picture those on the left and on the right.
    struct Corners {
        std::vector<PackedColour> left, right;
        std::vector<float> left_q, right_q;
    };
    template <class SubpixelsOf>
    static void find_places(int vertices, int pixels, SubpixelsOf subpixels_of, Places& places);
    void read_corners(const MappedLattice& lattice, int row, Corners& corners) const;

    VectorUnit unit_;
    Places columns_, rows_;
    Corners upper_, lower_;
};

}  // namespace touchable
