// SPDX-License-Identifier: Apache-2.0
#pragma once

// Surfaces painted with the CPU's vectors and threads: from frames to a lattice (CpuLattices), vertices at
// its edges (SurfaceEdges), fewer vertices (Decimation), its triangles from any view (LatticeRaster), whose
// silhouettes are smoothed (Silhouettes), or from the clip's own (OwnViewPicture); and all of it, picture
// after picture (CpuSurface). Each gives the same bits with any number of threads and any vectors. `threads`
// counts the calling thread; the others start on first use and sleep in between.

#include <array>

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "shaders/cut_rule.h"

namespace touchable {

/// Makes q and tiles of lattices on the CPU, with vectors and threads: the counterpart of GpuLattices, with
/// the arithmetic of shaders/unproject.h. The same bits with any number of threads and any vectors.
class CpuLattices {
public:
    /// One per core, up to the number that pays.
    static int usual_threads();
    explicit CpuLattices(int threads, VectorUnit vectors = usable_vector_units().front());

    /// The twin of `touchable::q_of`, which it calls if the frames have no codes
    /// (SurfaceUnproject::has_codes): the same pixels are 0, the others agree as SurfaceUnproject's do.
    /// `field` was made from `pair`.
    void q_of(const HeightField& field, const FramePair& pair, std::vector<float>& q);
    /// The non-empty tiles of a lattice with these q.
    ViewSurface::Tiles tiles_of(int width, int height, const std::vector<float>& q);

    /// Colours of the vertices of `field` from their q, with the arithmetic of shaders/light.h: the twin of
    /// `lit_colours`, to 2 of 255. `colour`: RGB of 8 bits, of the field's size, or empty for clay, which is
    /// always lit.
    void light(const HeightField& field, const std::vector<float>& q, const PlaneView& colour,
               Lighting lighting, std::vector<PackedColour>& colours, float cut_ratio = CUT_RULE_RATIO);

private:
    const VectorUnit unit_;
    RowBands bands_;
    std::vector<std::vector<float>> scratch_;  // by thread
    std::vector<float> u2_;                    // of the columns' rays, squared
    std::vector<std::uint8_t> classes_;        // of each tile
};

/// Finds, on the CPU, the vertices of a lattice that are drawn off their pixel (shaders/edge_rule.h); the
/// same result with any number of threads and any vectors. The clip's own view is drawn without them.
class SurfaceEdges {
public:
    struct Vertex {
        std::int32_t x;
        float at_x, at_y, q;  ///< where it is drawn, pixels
    };

    explicit SurfaceEdges(int threads, VectorUnit vectors = usable_vector_units().front());

    /// Erodes q (0: no surface), and finds the vertices.
    void find(const EdgeLattice& lattice);
    /// Forgets all of them.
    void clear() { rows_.clear(); }

    /// q as it was given, but negative where the surface is eroded; valid until the next `find`.
    const float* eroded_q() const { return eroded_.data(); }

    /// The vertices of a row, from left to right.
    std::span<const Vertex> row(int y) const;
    /// The moved vertex of a pixel, or null if it is drawn at its pixel.
    const Vertex* at(int x, int y) const;

private:
    /// One thread's masks of two rows of cells: whether pairs of neighbours are one surface, -1 or 0.
    struct Scratch {
        std::vector<std::int32_t> right, down, aslant, upper_down, upper_aslant, candidates;
    };
    void erode_rows(const EdgeLattice& lattice, const RowBand& band);
    void find_rows(const EdgeLattice& lattice, const RowBand& band);

    VectorUnit unit_;
    RowBands bands_;
    std::vector<Scratch> scratch_;
    std::vector<std::vector<Vertex>> rows_;
    std::vector<float> eroded_;
};

/// A surface reduced to every `step`th vertex across and down, for windows with fewer pixels than the clip: a
/// level of detail. For display only; touch uses all vertices.
class Decimation {
public:
    /// `threads` counts the calling thread. The same result with any number of threads and any vectors.
    explicit Decimation(int threads, VectorUnit vectors = usable_vector_units().front())
        : unit_(vectors), bands_(threads), scratch_(static_cast<std::size_t>(threads)) {}

    /// `field` was made from `pair`, whose frames have codes (SurfaceUnproject::has_codes); `colour`: RGB of
    /// 8 bits, of the field's size, or empty. All are read at once.
    void make(const HeightField& field, const FramePair& pair, const PlaneView& colour, int step);
    /// The decimated field, valid until the next `make`.
    const HeightField& field() const { return *field_; }
    const FramePair& pair() const { return pair_; }
    /// Averages of the pixels around each vertex; or empty.
    const PlaneView& colour() const { return colour_; }

private:
    /// Alternating buffers for repeated halving of a frame.
    using Halves = std::array<SurfaceFrame, 2>;
    /// Buffers for a row of colours, for one thread.
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
    std::vector<std::uint8_t> half_colours_[2];  // alternating, each halved from the other
};

/// A lattice in the CPU's memory, row by row.
struct MappedLattice {
    const float* q;
    const PackedColour* colours;
    int width, height;
    int step = 1;  ///< of the clip's pixels, from vertex to vertex (Decimation)
    bool fills_gaps = false;  ///< ViewSurface's

    // The interface that shaders/gap_fill.h needs from a lattice.
    friend float gap_q(const MappedLattice& lattice, const glm::ivec2& at) {
        return lattice.q[pixel_place(at.x, at.y, lattice.width)];
    }
    friend glm::vec3 gap_colour(const MappedLattice& lattice, const glm::ivec2& at) {
        const PackedColour c = lattice.colours[pixel_place(at.x, at.y, lattice.width)];
        return {c & 255U, c >> 8 & 255U, c >> 16 & 255U};
    }
};

/// Draws a lattice's triangles from any view on the CPU: the same bits with any number of threads and any
/// vectors.
class LatticeRaster {
public:
    explicit LatticeRaster(int threads, VectorUnit vectors = usable_vector_units().front());
    ~LatticeRaster();

    /// Writes colours and z (0: empty) of the camera's pixels. `edges` are those of `lattice`; `background`:
    /// a colour per row.
    void draw(MappedLattice lattice, const SurfaceEdges& edges, const ViewCamera& camera,
              std::span<const PackedColour> background, std::span<PackedColour> colours, std::span<float> z);

private:
    class Band;
    struct Rows;

    VectorUnit unit_;
    RowBands bands_;
    std::vector<Rows> rows_;             ///< by thread
    std::vector<std::uint64_t> pixels_;  ///< z's bits above the colour's, as in shaders/raster.h
};

/// Smooths the silhouettes of a picture with a sample a pixel, after a LatticeRaster: each pixel at one gets
/// as much of the colour beyond as the edge, which follows from its course, leaves there.
class Silhouettes {
public:
    explicit Silhouettes(VectorUnit vectors = usable_vector_units().front()) : unit_(vectors) {}
    void smooth(std::span<PackedColour> colours, std::span<const float> z, int width, int height);

private:
    /// Strides, and numbers of places: across silhouettes, and along them.
    struct Steps {
        int across, most_across, along, most_along;
    };
    void smooth_steps(const Steps& steps, std::span<PackedColour> colours) const;
    static const std::uint8_t* find_side(const std::uint8_t* from, const std::uint8_t* end);

    VectorUnit unit_;
    std::vector<std::uint8_t> sides_;  // of each pixel and the next, to the right or below
};

/// Draws the surface from the clip's own camera on the CPU. A vertex's screen position then does not depend
/// on its depth: the lattice's columns and rows are vertical and horizontal. So a pixel's cell, triangle and
/// position in it follow from its column and row alone.
class OwnViewPicture {
public:
    explicit OwnViewPicture(VectorUnit vectors = usable_vector_units().front()) : unit_(vectors) {}

    /// Whether a camera is the clip's own, with cells no larger than `raster` draws (RASTER_LARGE_CELL).
    static bool draws(const ViewCamera& camera);

    /// Writes colours and z (0: empty) of the camera's pixels. `background`: a colour per row.
    void draw(const MappedLattice& lattice, const ViewCamera& camera,
              std::span<const PackedColour> background, std::span<PackedColour> colours, std::span<float> z);

private:
    /// For each pixel along one side of the picture: its cell, and the position in the cell, 0 to 1.
    struct Places {
        int first = 0, end = 0;  ///< range of pixels that lie in a cell
        std::vector<int> cells;
        std::vector<float> into;
    };
    /// Vertices of a lattice row: the left and the right one for each column of the picture.
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

/// A surface painted picture after picture, in memory that is used again.
class CpuSurface {
public:
    /// As SurfaceDrawing::show. All is read at once.
    void show(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting,
              int step);
    /// Colours before the background, silhouettes smooth, and z (0: empty) of the camera's pixels, rows
    /// packed. Before the first `show` the background alone.
    void paint(const ViewCamera& camera, std::span<PackedColour> colours, std::span<float> z);

private:
    void make(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting,
              int step);

    CpuLattices lattices_{CpuLattices::usual_threads()};
    Decimation decimation_{CpuLattices::usual_threads()};
    SurfaceEdges edges_{CpuLattices::usual_threads()};
    LatticeRaster turned_view_{CpuLattices::usual_threads()};
    OwnViewPicture own_view_;
    Silhouettes silhouettes_;
    std::vector<float> q_;
    std::vector<PackedColour> colours_, background_;  // background_: of each row
    MappedLattice lattice_{};                         // of q_ and colours_
    float focal_length_ = 0;
    bool edges_are_found_ = false;
};

/// A painted picture of a surface in memory, rows packed.
struct FlatPicture {
    std::span<const PackedColour> colours;
    std::span<const float> z;  ///< ViewCamera's; 0: background
    int width = 0, height = 0;
};

/// The counterpart of `draw_dents` for CpuSurface. A pixel's displacement and light are computed at nodes and
/// interpolated linearly; a channel differs from `draw_dents` by a few of 255.
class DentPatches {
public:
    /// Takes the dents of fingers in a picture of the camera; false: there are none in sight.
    bool shape(std::span<const FingerMark> fingers, const MarkSizes& sizes, const ViewCamera& camera);
    /// Draws them over `to`, a copy of `flat`'s colours.
    void draw(const FlatPicture& flat, std::span<PackedColour> to);

private:
    struct Node {
        float right = 0, down = 0;  // from a pixel to its source, pixels
        float light = 1, gloss = 0;
    };
    void find_nodes(const FlatPicture& flat, const PixelBounds& bounds);
    void draw(const FlatPicture& flat, const PixelBounds& bounds, PackedColour* to) const;

    std::vector<SurfaceDent> dents_;
    std::vector<PixelBounds> seen_;  // where dents are in sight
    glm::dmat4 world_from_pixel_{1.0}, pixel_from_world_{1.0};
    std::vector<Node> nodes_;
    int step_ = 1, across_ = 0;  // pixels from one node to the next; nodes in a row
};

/// Stretches a picture, rows packed, over one twice as wide and high, to the bits of an exact linear filter:
/// 9, 3, 3 and 1 sixteenths of the nearest samples, rounded.
void double_picture(std::span<const PackedColour> from, int width, int height, std::span<PackedColour> to);

}  // namespace touchable
