#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/base/vector_unit.hpp"
#include "player/draw/lattice_row.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/surface_edges.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// Triangles of a lattice from any view, drawn by the CPU: the same bits with any number of threads and any
/// vectors. On a device that computes on the CPU it takes the place of the kernels raster and resolve: a lane
/// there waits for the largest cell of sixteen, which in a view from the side covers hundreds of pixels.
class LatticeRaster {
public:
    explicit LatticeRaster(int threads, VectorUnit vectors = usable_vector_units().front());

    /// Writes colours and z (0 is empty) of the camera's pixels, rows of `pitch`. `edges` are the lattice's
    /// own; `background`: a colour for each row.
    void draw(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera,
              std::span<const PackedColour> background, int pitch, std::span<PackedColour> colours,
              std::span<float> z);

private:
    class Band;
    /// Of a thread.
    struct Rows {
        LatticeRow upper, lower;
    };

    VectorUnit unit_;
    RowBands bands_;
    std::vector<Rows> rows_;
    std::vector<std::uint64_t> pixels_;  ///< z's bits above the colour's, as shaders/raster.h has them
};

}  // namespace touchable
