#include "player/draw/lattice_raster.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "engine/base/vectors.hpp"
#include "player/draw/decimation.hpp"
#include "player/draw/row_projection.hpp"
#include "player/draw/triangle_fill.hpp"
#include "player/draw/triangle_lanes.hpp"
#include "player/draw/view_rows.hpp"
#include "shaders/raster.h"

// Compiled without errno and traps: the loops over a row's vertices become vectors by themselves.

namespace touchable {
namespace {

/// Cells are drawn side by side where they have fewer pixels than this each way: larger ones would keep
/// their neighbours waiting.
constexpr int most_pixels = 4;

/// Of two that are equally near the greater colour: no order of drawing decides.
[[gnu::always_inline]] inline void keep_nearest(std::uint64_t& pixel, std::uint32_t z, PackedColour colour) {
    const std::uint64_t here = std::uint64_t{z} << 32 | colour;
    pixel = here > pixel ? here : pixel;
}

}  // namespace

/// Rows of the picture that one thread draws: all cells of the lattice that are seen there, row by row.
class LatticeRaster::Band {
public:
    Band(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera,
         const RowBand& band, int pitch, std::uint64_t* pixels)
        : lattice_(lattice),
          edges_(edges),
          projection_(lattice, edges, camera),
          view_(rows_of(camera)),
          q_(lattice.q),
          colours_(lattice.colours),
          width_(camera.width),
          first_(band.first),
          last_(band.last - 1),
          height_(camera.height),
          pitch_(pitch),
          cut_ratio_(is_own_view(camera) ? std::numeric_limits<float>::max() : cut_ratio(lattice.step)),
          pixels_(pixels) {}

    void draw(VectorUnit unit, Rows& rows) {
        const auto all = [&](auto kind) __attribute__((always_inline)) {
            // Of 512 bits at once compilers make little that is good.
            constexpr int n = std::min<int>(sizeof(typename decltype(kind)::Lanes) / sizeof(float), 8);
            projection_.project<n>(0, rows.lower);
            for (int y = 0; y + 1 < lattice_.height; ++y) {
                std::swap(rows.upper, rows.lower);
                projection_.project<n>(y + 1, rows.lower);
                if (!meets(rows)) continue;
                for (int x = 0; x + 1 < lattice_.width; x += n) draw_cells<n>(rows, x, y);
            }
        };
        run_vectors(unit, all);
    }

private:
    /// Whether a row of cells can be seen in these rows of the picture.
    bool meets(const Rows& rows) const {
        if (!rows.upper.is_in_front || !rows.lower.is_in_front) return true;
        const int least = std::min(rows.upper.least_y, rows.lower.least_y),
                  most = std::max(rows.upper.most_y, rows.lower.most_y);
        if (least > most) return false;  // they have no surface
        return first_pixel(least) <= last_ && last_pixel(most) >= first_;
    }

    template <int n>
    struct Cells {
        Corners<n> top_left, top_right, bottom_right, bottom_left;
    };

    /// Pixels that cells may cover: the first one, and how many follow to the right and down; less than 0
    /// where there is none.
    template <int n>
    struct Extent {
        Ints<n> first_x, first_y, beyond_x, beyond_y;
        Ints<n> is_large;  ///< for products of 32 bits
    };

    template <int n>
    [[gnu::always_inline]] Extent<n> extent_of(const Cells<n>& cells) const {
        using I = Ints<n>;
        const auto& [top_left, top_right, bottom_right, bottom_left] = cells;
        const I least_x = lesser(lesser(top_left.x, top_right.x), lesser(bottom_left.x, bottom_right.x)),
                most_x = greater(greater(top_left.x, top_right.x), greater(bottom_left.x, bottom_right.x)),
                least_y = lesser(lesser(top_left.y, top_right.y), lesser(bottom_left.y, bottom_right.y)),
                most_y = greater(greater(top_left.y, top_right.y), greater(bottom_left.y, bottom_right.y));
        const I first_x = greater(first_pixel(least_x), I{}),
                first_y = greater(first_pixel(least_y), I{} + first_);
        return {first_x, first_y, lesser(last_pixel(most_x), I{} + (width_ - 1)) - first_x,
                lesser(last_pixel(most_y), I{} + last_) - first_y,
                (most_x - least_x >= RASTER_LARGE_CELL) | (most_y - least_y >= RASTER_LARGE_CELL)};
    }

    /// n cells from (x, y) on.
    template <int n>
    [[gnu::always_inline]] void draw_cells(const Rows& rows, int x, int y) {
        using F = Floats<n>;
        using I = Ints<n>;
        const LatticeRow &up = rows.upper, &low = rows.lower;
        const F q00 = load<F>(&up.q[x]), q10 = load<F>(&up.q[x + 1]), q01 = load<F>(&low.q[x]),
                q11 = load<F>(&low.q[x + 1]);
        const I no_right = cut(q00, q10, q11, cut_ratio_), no_left = cut(q00, q11, q01, cut_ratio_);
        I is_drawn = ~(no_right & no_left);
        if (or_of(is_drawn) == 0) return;
        Cells<n> cells{corners_of<n>(up, x), corners_of<n>(up, x + 1), corners_of<n>(low, x + 1),
                       corners_of<n>(low, x)};
        cells.top_right.x = no_right ? cells.top_left.x : cells.top_right.x;  // without area: not drawn
        cells.top_right.y = no_right ? cells.top_left.y : cells.top_right.y;
        cells.bottom_left.x = no_left ? cells.top_left.x : cells.bottom_left.x;
        cells.bottom_left.y = no_left ? cells.top_left.y : cells.bottom_left.y;
        const I diagonal_starts = load<I>(&up.in_front[x]), diagonal_ends = load<I>(&low.in_front[x + 1]),
                right_is = load<I>(&up.in_front[x + 1]), left_is = load<I>(&low.in_front[x]);
        const I in_front = diagonal_starts & diagonal_ends & (right_is | no_right) & (left_is | no_left),
                partly = diagonal_starts | diagonal_ends | (right_is & ~no_right) | (left_is & ~no_left);
        const Extent<n> extent = extent_of(cells);
        // Where part of a cell is behind the eye, its corners say nothing of where it is seen.
        is_drawn &= partly & (~in_front | ((extent.beyond_x >= 0) & (extent.beyond_y >= 0)));
        if (or_of(is_drawn) == 0) return;
        if (const I large = is_drawn & (extent.is_large | ~in_front); or_of(large) != 0) {
            for (int k = 0; k < n; ++k)
                if (large[k] != 0) draw_cell(x + k, y, no_right[k] != 0, no_left[k] != 0);
            is_drawn &= ~large;
        }
        // A pixel is asked which of a cell's triangles it is in; where the cell is seen folded, it may be
        // both.
        const I folded =
            ~(no_right | no_left) & (turned(cells.top_left, cells.top_right, cells.bottom_right) !=
                                     turned(cells.top_left, cells.bottom_right, cells.bottom_left));
        for (bool again = false;; again = true) {
            Cells<n> shown = cells;
            plot_cells(shown, extent, is_drawn);
            is_drawn &= folded;
            if (again || or_of(is_drawn) == 0) return;
            cells.top_right = cells.top_left;
        }
    }

    /// Each from its own first pixel on: small ones side by side, larger ones one after the other.
    template <int n>
    [[gnu::always_inline]] void plot_cells(Cells<n>& cells, const Extent<n>& extent,
                                           const Ints<n>& is_drawn) {
        using I = Ints<n>;
        const auto& [first_x, first_y, beyond_x, beyond_y, is_large] = extent;
        for (Corners<n>* const corner :
             {&cells.top_left, &cells.top_right, &cells.bottom_left, &cells.bottom_right}) {
            corner->x = (corner->x - first_x * VIEW_SUBPIXELS - half_pixel) & is_drawn;
            corner->y = (corner->y - first_y * VIEW_SUBPIXELS - half_pixel) & is_drawn;
        }
        // What is not drawn is kept apart from other threads' pixels, too.
        const I start = is_drawn ? first_y * pitch_ + first_x : I{} + first_ * pitch_;
        const I is_small = is_drawn & (beyond_x < most_pixels) & (beyond_y < most_pixels);
        if (const I others = is_drawn & ~is_small; or_of(others) != 0)
            for (int k = 0; k < n; ++k)
                if (others[k] != 0) plot_cell<n>(cells, k, start[k], beyond_x[k], beyond_y[k]);
        if (or_of(is_small) == 0) return;
        // A bit for each column, and for each line, that one of them has.
        const std::uint32_t extents =
            or_of(is_small & (17 | ((beyond_x > 0) & 2) | ((beyond_x > 1) & 4) | ((beyond_x > 2) & 8) |
                              ((beyond_y > 0) & 32) | ((beyond_y > 1) & 64) | ((beyond_y > 2) & 128)));
        plot_pixels<n, 1>(cells, start, is_small ? beyond_x : ~I{}, beyond_y & is_small,
                          std::bit_width(extents & 15U), std::bit_width(extents >> 4));
    }

    /// One cell, with neighbouring pixels side by side.
    template <int n>
    [[gnu::always_inline]] void plot_cell(const Cells<n>& cells, int k, int start, int beyond_x,
                                          int beyond_y) {
        const Ints<n> lane = __builtin_convertvector(lane_numbers<n>(), Ints<n>);
        const auto one = [&](const Corners<n>& of) __attribute__((always_inline)) {
            return Corners<n>{Ints<n>{} + of.x[k] - lane * VIEW_SUBPIXELS,
                              Ints<n>{} + of.y[k],
                              Floats<n>{} + of.z[k],
                              Floats<n>{} + of.share[k],
                              Floats<n>{} + of.red[k],
                              Floats<n>{} + of.green[k],
                              Floats<n>{} + of.blue[k]};
        };
        plot_pixels<n, n>(
            {one(cells.top_left), one(cells.top_right), one(cells.bottom_right), one(cells.bottom_left)},
            lesser(Ints<n>{} + start + lane, Ints<n>{} + (start + beyond_x)), beyond_x - lane,
            Ints<n>{} + beyond_y, beyond_x / n + 1, beyond_y + 1);
    }

    /// Pixels of cells: each lane has its first one at `start`, every `step`th column from there on up to
    /// `beyond_x` more, none where that is less than 0, and `beyond_y` lines after the first.
    template <int n, int step>
    [[gnu::always_inline]] void plot_pixels(const Cells<n>& cells, const Ints<n>& start,
                                            const Ints<n>& beyond_x, const Ints<n>& beyond_y, int columns,
                                            int lines) {
        using F = Floats<n>;
        using I = Ints<n>;
        const Corners<n>&top_left = cells.top_left, &top_right = cells.top_right,
              &bottom_right = cells.bottom_right, &bottom_left = cells.bottom_left;
        const TriangleLanes<n> right(top_left, top_right, bottom_right,
                                     turned(top_left, top_right, bottom_right)),
            left(top_left, bottom_right, bottom_left, turned(top_left, bottom_right, bottom_left));
        Place<n> right_line(right), left_line(left);
        I line_start = start;
        for (int line = 0; line < lines; ++line) {
            Place<n> in_right = right_line, in_left = left_line;
            const I is_line = beyond_y >= line;
            for (int column = 0; column < columns; ++column) {
                const I is_right = in_right.is_inside();
                const I is_here = (is_right | in_left.is_inside()) & is_line & (beyond_x >= step * column);
                const F scale = is_right ? right.scale : left.scale;
                const F of_b = __builtin_convertvector(
                                   is_right ? in_right.ca + right.ca.least : in_left.ca + left.ca.least, F) *
                               scale,
                        of_c = __builtin_convertvector(
                                   is_right ? in_right.ab + right.ab.least : in_left.ab + left.ab.least, F) *
                               scale;
                const auto mixed = [&](F Corners<n>::*value) __attribute__((always_inline)) {
                    return top_left.*value + of_b * (is_right ? right.b.*value : left.b.*value) +
                           of_c * (is_right ? right.c.*value : left.c.*value);
                };
                const F z = mixed(&Corners<n>::z), share = mixed(&Corners<n>::share);
                const auto byte = [&](F Corners<n>::*value) __attribute__((always_inline)) {
                    return __builtin_convertvector(mixed(value) / share + 0.5F, I);
                };
                const I colour = byte(&Corners<n>::red) | byte(&Corners<n>::green) << 8 |
                                 byte(&Corners<n>::blue) << 16 | static_cast<std::int32_t>(0xff000000U);
                const I place = line_start + greater(lesser(beyond_x, I{} + step * column), I{});
                keep<n>(place, is_here & (z > 0.0F), z, colour);
                in_right.go_right(right, step);
                in_left.go_right(left, step);
            }
            right_line.go_down(right);
            left_line.go_down(left);
            line_start += (beyond_y > line) & pitch_;
        }
    }

    /// All ones where a triangle's corners go counterclockwise on the screen.
    template <int n>
    [[gnu::always_inline]] static Ints<n> turned(const Corners<n>& a, const Corners<n>& b,
                                                 const Corners<n>& c) {
        return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0;
    }

    template <int n>
    [[gnu::always_inline]] void keep(const Ints<n>& at, const Ints<n>& is_here, const Floats<n>& z,
                                     const Ints<n>& colour) {
        alignas(64) std::array<std::int32_t, n> places;
        alignas(64) std::array<std::uint32_t, n> depths, colours;
        const Ints<n> bits = std::bit_cast<Ints<n>>(z) & is_here, seen = colour & is_here;
        std::memcpy(places.data(), &at, sizeof(at));
        std::memcpy(depths.data(), &bits, sizeof(bits));
        std::memcpy(colours.data(), &seen, sizeof(seen));
        for (std::size_t k = 0; k < n; ++k) keep_nearest(pixels_[places[k]], depths[k], colours[k]);
    }

    /// One that is larger on the screen, or in part before the near plane.
    void draw_cell(int x, int y, bool no_right, bool no_left) {
        const auto corner = [&](int i, int j) {
            const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(j) * lattice_.pitch + i;
            const PackedColour c = colours_[at];
            const glm::vec3 colour(c & 255U, c >> 8 & 255U, c >> 16 & 255U);
            if (const SurfaceEdges::Vertex* edge = edges_.at(i, j); edge != nullptr)
                return FillCorner{view_clip(view_, edge->at_x, edge->at_y, edge->q), colour * edge->light};
            return FillCorner{view_clip(view_, static_cast<float>(i), static_cast<float>(j), q_[at]), colour};
        };
        const auto fill_one = [&](const std::array<FillCorner, 3>& corners) {
            fill_triangle(corners, width_, height_, [&](int px, int py, float z, const glm::vec3& colour) {
                const glm::uvec3 byte(colour + 0.5F);
                if (z > 0.0F && py >= first_ && py <= last_)
                    keep_nearest(pixels_[static_cast<std::ptrdiff_t>(py) * pitch_ + px],
                                 std::bit_cast<std::uint32_t>(z), pack_colour(byte.r, byte.g, byte.b));
            });
        };
        const FillCorner top_left = corner(x, y), bottom_right = corner(x + 1, y + 1);
        if (!no_right) fill_one({top_left, corner(x + 1, y), bottom_right});
        if (!no_left) fill_one({top_left, bottom_right, corner(x, y + 1)});
    }

    const MappedLattice& lattice_;
    const SurfaceEdges& edges_;
    const RowProjection projection_;
    const ViewRows view_;
    const float* const q_;
    const PackedColour* const colours_;
    const int width_, first_, last_, height_, pitch_;
    const float cut_ratio_;  // in the clip's own view holes alone are cut
    std::uint64_t* const pixels_;
};

LatticeRaster::LatticeRaster(int threads, VectorUnit vectors)
    : unit_(vectors), bands_(threads), rows_(static_cast<std::size_t>(threads)) {}

void LatticeRaster::draw(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera,
                         std::span<const PackedColour> background, int pitch, std::span<PackedColour> colours,
                         std::span<float> z) {
    pixels_.resize(static_cast<std::size_t>(pitch) * static_cast<std::size_t>(camera.height));
    const auto row_of = [pitch](int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(pitch);
    };
    // A band for each thread: none writes where another does, and each goes through the lattice once.
    const int rows_each = (camera.height + bands_.threads() - 1) / bands_.threads();
    bands_.for_each_band(camera.height, rows_each, [&](const RowBand& band) {
        std::fill(pixels_.begin() + static_cast<std::ptrdiff_t>(row_of(band.first)),
                  pixels_.begin() + static_cast<std::ptrdiff_t>(row_of(band.last)), std::uint64_t{0});
        Band(lattice, edges, camera, band, pitch, pixels_.data())
            .draw(unit_, rows_[static_cast<std::size_t>(band.thread)]);
        for (int y = band.first; y < band.last; ++y) {
            const std::uint64_t* from = pixels_.data() + row_of(y);
            PackedColour* const to = colours.data() + row_of(y);
            float* const to_z = z.data() + row_of(y);
            const PackedColour empty = background[static_cast<std::size_t>(y)];
            for (int x = 0; x < camera.width; ++x) {
                to[x] = from[x] != 0 ? static_cast<PackedColour>(from[x]) : empty;
                to_z[x] = std::bit_cast<float>(static_cast<std::uint32_t>(from[x] >> 32));
            }
        }
    });
}

}  // namespace touchable
