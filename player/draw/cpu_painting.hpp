#pragma once

// Surfaces painted by the CPU's vectors and threads: from frames to a lattice (CpuLattices), the vertices at
// its edges (SurfaceEdges), fewer vertices (Decimation), its triangles from any view (LatticeRaster), and
// from the clip's own (OwnViewPicture). Each gives the same bits with any number of threads and any vectors.
// `threads` counts the one that calls; the others start when first needed and sleep in between.

#include <array>

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/pictures.hpp"
#include "player/draw/view.hpp"
#include "shaders/cut_rule.h"

namespace touchable {

/// Makes q and tiles of lattices on the CPU, by its vectors and on threads: what GpuLattices does on a GPU,
/// with the arithmetic of shaders/unproject.h. The same bits with any number of threads and any vectors.
class CpuLattices {
public:
    /// A core each, as far as that pays.
    static int usual_threads();
    explicit CpuLattices(int threads, VectorUnit vectors = usable_vector_units().front());
    ~CpuLattices();

    /// The twin of `touchable::q_of`, which it calls where the frames have no codes
    /// (SurfaceUnproject::has_codes): the same pixels are 0, the others agree as SurfaceUnproject's. `pair`
    /// is what `field` was made of.
    void q_of(const HeightField& field, const FramePair& pair, std::vector<float>& q);
    /// The same of frames that have codes, in rows of `pitch` floats, 0 beyond the width.
    void q_of(const HeightField& field, const FramePair& pair, float* q, int pitch);
    /// Which tiles of a lattice of these q are worth drawing.
    ViewSurface::Tiles tiles_of(int width, int height, const std::vector<float>& q);

    /// Colours of the vertices of `field`, whose q is there, with the arithmetic of shaders/light.h: the twin
    /// of `lit_colours`, to 2 of 255. Both in rows of `pitch`. `colour`: RGB of 8 bits, of the field's size,
    /// or empty for clay, which is always lit.
    void light(const HeightField& field, const float* q, int pitch, const PlaneView& colour,
               Lighting lighting, PackedColour* colours, float cut_ratio = CUT_RULE_RATIO);

    /// `make_view_surface`, with q and tiles as above.
    ViewSurface surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour);

private:
    class LightRows;

    const VectorUnit unit_;
    RowBands bands_;
    std::vector<std::vector<float>> scratch_;  // by thread
    std::vector<LightRows> light_rows_;        // also by thread
    std::vector<float> u2_;                    // of the columns' rays, squared
    std::vector<std::uint8_t> classes_;        // of each tile
};

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

    /// Finds them in q, in rows of `pitch`; 0 is no surface. `are_values`: colours are those of a scale, and
    /// are not shaded.
    void find(const float* q, int width, int height, int pitch, float cut_ratio = CUT_RULE_RATIO,
              bool are_values = false);
    /// Forgets all of them.
    void clear() { rows_.clear(); }

    /// The vertices of a row, from left to right.
    std::span<const Vertex> row(int y) const;
    /// The vertex of a pixel, or null where it is drawn at its pixel.
    const Vertex* at(int x, int y) const;

private:
    /// For one thread: which pairs of neighbours are one surface, -1 or 0, for two rows of cells.
    struct Scratch {
        std::vector<std::int32_t> right, down, aslant, upper_down, upper_aslant, candidates;
    };
    void find_rows(const EdgeLattice& lattice, bool are_values, const RowBand& band);

    VectorUnit unit_;
    RowBands bands_;
    std::vector<Scratch> scratch_;
    std::vector<std::vector<Vertex>> rows_;
};

/// A moment's surface with every `step`th vertex across and down, for windows whose pixels do not tell more
/// of them apart: a level of detail. It serves the eye alone; what is touched has all vertices.
class Decimation {
public:
    /// `threads` with the one that calls. The same with any number of them, and any vectors.
    explicit Decimation(int threads, VectorUnit vectors = usable_vector_units().front())
        : unit_(vectors), bands_(threads), scratch_(static_cast<std::size_t>(threads)) {}

    /// `pair`, whose frames have codes (SurfaceUnproject::has_codes), is what `field` was made of; `colour`:
    /// RGB of 8 bits, of the field's size, or empty. Reads them now and not later.
    void make(const HeightField& field, const FramePair& pair, const PlaneView& colour, int step);
    /// The field that was made last; until the next `make`.
    const HeightField& field() const { return *field_; }
    const FramePair& pair() const { return pair_; }
    /// Means of the pixels around each vertex; or empty.
    const PlaneView& colour() const { return colour_; }

private:
    /// A frame's halves, and theirs.
    using Halves = std::array<SurfaceFrame, 2>;
    /// A row of colours, for one thread.
    struct Scratch {
        std::vector<std::uint16_t> sums;
        std::vector<std::uint8_t> means;
    };
    void halve_frame(const SurfaceFrame& from, SurfaceFrame& to);
    const SurfaceFrame* decimated_frame(const SurfaceFrame& frame, int step, Halves& halves);
    void halve_colour(const PlaneView& from, std::vector<std::uint8_t>& to);
    void halve_colour_row(const PlaneView& from, int y, Scratch& of_thread, std::uint8_t* out) const;

    const VectorUnit unit_;
    RowBands bands_;
    std::vector<Scratch> scratch_;
    Halves prev_, next_;
    Scene scene_;
    FramePair pair_;
    std::optional<HeightField> field_;
    PlaneView colour_;
    std::vector<std::uint8_t> half_colours_[2];  // each made of the other
};

/// A lattice in the CPU's memory: rows of `pitch` vertices.
struct MappedLattice {
    const float* q;
    const PackedColour* colours;
    int width, height, pitch;
    int step = 1;  ///< of the clip's pixels, from vertex to vertex (Decimation)
};

/// Triangles of a lattice from any view, drawn by the CPU: the same bits with any number of threads and any
/// vectors. On a device that computes on the CPU it takes the place of the kernels raster and resolve: a lane
/// there waits for the largest cell of sixteen, which in a view from the side covers hundreds of pixels.
class LatticeRaster {
public:
    explicit LatticeRaster(int threads, VectorUnit vectors = usable_vector_units().front());
    ~LatticeRaster();

    /// Writes colours and z (0 is empty) of the camera's pixels, rows of `pitch`. `edges` are the lattice's
    /// own; `background`: a colour for each row.
    void draw(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera,
              std::span<const PackedColour> background, int pitch, std::span<PackedColour> colours,
              std::span<float> z);

private:
    class Band;
    struct Rows;

    VectorUnit unit_;
    RowBands bands_;
    std::vector<Rows> rows_;             ///< of each thread
    std::vector<std::uint64_t> pixels_;  ///< z's bits above the colour's, as shaders/raster.h has them
};

/// The surface as the clip's own camera sees it, drawn by the CPU. From there a vertex is seen where it is
/// at any depth: columns and rows of the lattice are upright and level on the screen. So the cell, the
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
    /// For each pixel along one side of the picture: the cell before it, and how far it is into that, 0 to 1.
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
