// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <vector>

#include "engine/base/vectors.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/gap_fill.h"
#include "shaders/raster.h"
#include "shaders/view_project.h"

// Compiled without errno and floating-point traps, so that plain loops over a row are auto-vectorised.
//
// LatticeRaster draws one triangle per vector lane, with the arithmetic of fill_triangle. Vectors are never
// passed to a function that is not inlined (see vectors.hpp).

namespace touchable {
namespace {

/// A row of projected vertices. Colours are multiplied by share, 1 / w.
struct LatticeRow {
    void resize(std::size_t vertices) {
        for (auto* each : {&x, &y, &in_front}) each->resize(vertices);
        for (auto* each : {&q, &z, &share, &red, &green, &blue}) each->resize(vertices);
        colours.resize(vertices);
    }
    std::vector<std::int32_t> x, y;      ///< subpixels
    std::vector<std::int32_t> in_front;  ///< -1 if beyond the near plane, otherwise 0
    std::vector<float> q, z, share, red, green, blue;
    std::vector<PackedColour> colours;
    std::int32_t least_y = 0, most_y = 0;  ///< over valid vertices
    bool is_in_front = false;              ///< all valid vertices
};

constexpr int half_pixel = VIEW_SUBPIXELS / 2;
template <class T, int n>
struct Lanes {
    typedef T Type __attribute__((vector_size(n * sizeof(T))));
};
template <int n>
using Ints = typename Lanes<std::int32_t, n>::Type;
template <int n>
using Floats = typename Lanes<float, n>::Type;

template <class V, class T>
[[gnu::always_inline]] inline V load(const T* from) {
    V values;
    std::memcpy(&values, from, sizeof(values));
    return values;
}

template <class V, class T>
[[gnu::always_inline]] inline void store(const V& values, T* to) {
    std::memcpy(to, &values, sizeof(values));
}

/// 0, 1, 2, ...
template <int n>
[[gnu::always_inline]] inline Floats<n> lane_numbers() {
    Floats<n> numbers{};
    for (int k = 0; k < n; ++k) numbers[k] = static_cast<float>(k);
    return numbers;
}

/// Bitwise or of all lanes.
template <class V>
[[gnu::always_inline]] inline std::uint32_t or_of(const V& values) {
    std::array<std::uint64_t, sizeof(V) / 8> words;
    std::memcpy(words.data(), &values, sizeof(V));
    std::uint64_t all = 0;
    for (const std::uint64_t word : words) all |= word;
    return static_cast<std::uint32_t>(all | all >> 32);
}

/// The first pixel centre at or after a position in subpixels, and the last one at or before it.
template <class T>
[[gnu::always_inline]] inline T first_pixel(T subpixels) {
    return (subpixels + (half_pixel - 1)) >> 8;
}
template <class T>
[[gnu::always_inline]] inline T last_pixel(T subpixels) {
    return (subpixels - half_pixel) >> 8;
}

/// `triangle_is_cut` by lanes, with this ratio.
template <class F>
[[gnu::always_inline]] inline auto cut(const F& q0, const F& q1, const F& q2, float ratio) {
    F least = lesser(q0, q1), most = greater(q0, q1);
    least = lesser(q2, least);
    most = greater(q2, most);
    return ~(least > 0.0F) | (most > ratio * least);
}

/// `view_row` by lanes.
template <class F>
[[gnu::always_inline]] inline F clip(const glm::vec4& row, const F& x, const F& y, const F& q) {
    F sum = row.x * x;
    sum = sum + row.y * y;
    sum = sum + row.z;
    return sum + row.w * q;
}

/// `view_subpixels` by lanes. NaN, from vertices that are not drawn, becomes the guard.
template <int n>
[[gnu::always_inline]] inline Ints<n> subpixels(const Floats<n>& ndc, float size) {
    Floats<n> at = (ndc * 0.5F + 0.5F) * (size * static_cast<float>(VIEW_SUBPIXELS)) + 0.5F;
    // Clamping after adding 0.5 changes nothing: large floats have no halves, and the guard is even.
    at = at > -VIEW_GUARD ? at : Floats<n>{} - VIEW_GUARD;
    at = at < VIEW_GUARD ? at : Floats<n>{} + VIEW_GUARD;
    const Ints<n> whole = __builtin_convertvector(at, Ints<n>);  // towards 0
    return whole + (__builtin_convertvector(whole, Floats<n>) > at);
}

/// Corners of adjacent cells, one per lane. x, y: subpixels from the centre of each cell's first pixel.
/// Colours are multiplied by share, 1 / w.
template <int n>
struct Corners {
    Ints<n> x, y;
    Floats<n> z, share, red, green, blue;
};

/// Twice the signed area of each a, b, (0, 0), minus the least value inside (fill::least_inside), and its
/// increments per pixel.
template <int n>
struct EdgeLanes {
    [[gnu::always_inline]] EdgeLanes(const Corners<n>& a, const Corners<n>& b) {
        const Ints<n> dx = b.x - a.x, dy = b.y - a.y;
        least = ((dy < 0) | ((dy == 0) & (dx > 0))) + 1;
        here = dy * a.x - dx * a.y - least;
        right = -dy * VIEW_SUBPIXELS;
        down = dx * VIEW_SUBPIXELS;
    }
    Ints<n> least, here, right, down;
};

/// One triangle per lane, each oriented so that its edges are positive inside.
template <int n>
struct TriangleLanes {
    [[gnu::always_inline]] TriangleLanes(const Corners<n>& first, const Corners<n>& second,
                                         const Corners<n>& third, const Ints<n>& turns)
        : b(chosen(turns, third, second)),
          c(chosen(turns, second, third)),
          ab(first, b),
          bc(b, c),
          ca(c, first),
          scale(1.0F / __builtin_convertvector(ab.here + ab.least + bc.here + bc.least + ca.here + ca.least,
                                               Floats<n>)) {
        for (auto* const each : {&b, &c}) {
            each->z -= first.z;
            each->share -= first.share;
            each->red -= first.red;
            each->green -= first.green;
            each->blue -= first.blue;
        }
    }
    [[gnu::always_inline]] static Corners<n> chosen(const Ints<n>& mask, const Corners<n>& one,
                                                    const Corners<n>& other) {
        return {mask ? one.x : other.x,         mask ? one.y : other.y,     mask ? one.z : other.z,
                mask ? one.share : other.share, mask ? one.red : other.red, mask ? one.green : other.green,
                mask ? one.blue : other.blue};
    }

    Corners<n> b, c;  ///< z, share and colours: minus the first corner's
    EdgeLanes<n> ab, bc, ca;
    Floats<n> scale;  ///< 1 / twice the area
};

/// A pixel's edge values in each lane's triangle.
template <int n>
struct LanePlace {
    [[gnu::always_inline]] explicit LanePlace(const TriangleLanes<n>& t)
        : ab(t.ab.here), bc(t.bc.here), ca(t.ca.here) {}
    [[gnu::always_inline]] void go_right(const TriangleLanes<n>& t, int step) {
        ab += t.ab.right * step;
        bc += t.bc.right * step;
        ca += t.ca.right * step;
    }
    [[gnu::always_inline]] void go_down(const TriangleLanes<n>& t) {
        ab += t.ab.down;
        bc += t.bc.down;
        ca += t.ca.down;
    }
    [[gnu::always_inline]] Ints<n> is_inside() const { return (ab | bc | ca) >= 0; }
    Ints<n> ab, bc, ca;
};

/// n vertices of a row from x on, as cell corners.
template <int n>
[[gnu::always_inline]] inline Corners<n> corners_of(const LatticeRow& row, int x) {
    using F = Floats<n>;
    using I = Ints<n>;
    return {load<I>(&row.x[x]),   load<I>(&row.y[x]),     load<F>(&row.z[x]),   load<F>(&row.share[x]),
            load<F>(&row.red[x]), load<F>(&row.green[x]), load<F>(&row.blue[x])};
}

/// Projects rows of a lattice's vertices to a camera's screen, n vertices at a time.
class RowProjection {
public:
    RowProjection(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera)
        : lattice_(lattice),
          edges_(edges),
          fills_holes_(lattice.fills_gaps && is_own_view(camera)),
          view_(rows_of(camera)),
          screen_width_(static_cast<float>(camera.width)),
          screen_height_(static_cast<float>(camera.height)) {}

    /// Row y, padded beyond the width with invalid vertices.
    template <int n>
    [[gnu::always_inline]] void project(int y, LatticeRow& row) const {
        using F = Floats<n>;
        using I = Ints<n>;
        const auto count = static_cast<std::size_t>(lattice_.width);
        const std::ptrdiff_t start = std::ptrdiff_t{y} * lattice_.width;
        row.resize((count + n) / n * n + n);
        std::memcpy(row.q.data(), lattice_.q + start, count * sizeof(float));
        for (std::size_t i = 0; fills_holes_ && i < count; ++i) row.q[i] = std::max(row.q[i], HOLE_Q);
        std::fill(row.q.begin() + static_cast<std::ptrdiff_t>(count), row.q.end(), 0.0F);
        std::memcpy(row.colours.data(), lattice_.colours + start, count * sizeof(PackedColour));
        const F at = F{} + static_cast<float>(y);
        I least_y = I{} + std::numeric_limits<std::int32_t>::max(), most_y = ~least_y, in_front = ~I{};
        F column = lane_numbers<n>();
        for (std::size_t i = 0; i < count; i += n, column += static_cast<float>(n)) {
            const F q = load<F>(&row.q[i]);
            const Placed<n> placed = place<n>(column, at, q < 0.0F ? -q : q, load<I>(&row.colours[i]));
            store(placed.x, &row.x[i]);
            store(placed.y, &row.y[i]);
            store(placed.in_front, &row.in_front[i]);
            store(placed.z, &row.z[i]);
            store(placed.share, &row.share[i]);
            store(placed.red * placed.share, &row.red[i]);
            store(placed.green * placed.share, &row.green[i]);
            store(placed.blue * placed.share, &row.blue[i]);
            const I is_there = q != 0.0F;
            least_y = (is_there & (placed.y < least_y)) ? placed.y : least_y;
            most_y = (is_there & (placed.y > most_y)) ? placed.y : most_y;
            in_front &= placed.in_front | ~is_there;
        }
        row.least_y = row.most_y = 0;
        row.is_in_front = or_of(~in_front) == 0;
        for (int k = 0; k < n; ++k) {
            row.least_y = k == 0 ? least_y[k] : std::min(row.least_y, least_y[k]);
            row.most_y = k == 0 ? most_y[k] : std::max(row.most_y, most_y[k]);
        }
        move_edges<n>(y, row);
    }

private:
    /// n projected vertices, as in LatticeRow, but with colours not yet multiplied by share.
    template <int n>
    struct Placed {
        Ints<n> x, y, in_front;
        Floats<n> z, share, red, green, blue;
    };
    template <int n>
    [[gnu::always_inline]] Placed<n> place(const Floats<n>& column, const Floats<n>& at, const Floats<n>& q,
                                           const Ints<n>& colour) const {
        using F = Floats<n>;
        const F w = clip(view_.w, column, at, q), z = clip(view_.z, column, at, q);
        return {subpixels<n>(clip(view_.x, column, at, q) / w, screen_width_),
                subpixels<n>(clip(view_.y, column, at, q) / w, screen_height_),
                w - z >= 0.0F,
                z / w,
                1.0F / w,
                __builtin_convertvector(colour & 255, F),
                __builtin_convertvector(colour >> 8 & 255, F),
                __builtin_convertvector(colour >> 16 & 255, F)};
    }

    /// Projects the moved vertices to their places, n at a time; leaves q, which decides the cutting of
    /// triangles.
    template <int n>
    [[gnu::always_inline]] void move_edges(int y, LatticeRow& row) const {
        using F = Floats<n>;
        using I = Ints<n>;
        const std::span<const SurfaceEdges::Vertex> edges = edges_.row(y);
        for (std::size_t first = 0; first < edges.size(); first += n) {
            const std::size_t count = std::min<std::size_t>(n, edges.size() - first);
            F column{}, at{}, q{};
            I colour{};
            for (std::size_t k = 0; k < n; ++k) {
                const SurfaceEdges::Vertex& edge = edges[first + std::min(k, count - 1)];
                column[k] = edge.at_x;
                at[k] = edge.at_y;
                q[k] = edge.q;
                colour[k] = static_cast<std::int32_t>(row.colours[static_cast<std::size_t>(edge.x)]);
            }
            const Placed<n> placed = place<n>(column, at, q, colour);
            const F red = placed.red * placed.share, green = placed.green * placed.share,
                    blue = placed.blue * placed.share;
            for (std::size_t k = 0; k < count; ++k) {
                const auto i = static_cast<std::size_t>(edges[first + k].x);
                row.x[i] = placed.x[k];
                row.y[i] = placed.y[k];
                row.in_front[i] = placed.in_front[k];
                row.z[i] = placed.z[k];
                row.share[i] = placed.share[k];
                row.red[i] = red[k];
                row.green[i] = green[k];
                row.blue[i] = blue[k];
                row.least_y = std::min(row.least_y, placed.y[k]);
                row.most_y = std::max(row.most_y, placed.y[k]);
                row.is_in_front = row.is_in_front && placed.in_front[k] != 0;
            }
        }
    }

    const MappedLattice& lattice_;
    const SurfaceEdges& edges_;
    const bool fills_holes_;
    const ViewRows view_;
    const float screen_width_, screen_height_;
};

/// Cells with fewer pixels than this each way are drawn one per lane; larger ones would keep the other lanes
/// waiting.
constexpr int most_pixels = 4;

/// Of two equally near pixels the greater colour wins, so the order of drawing does not matter.
[[gnu::always_inline]] inline void keep_nearest(std::uint64_t& pixel, std::uint32_t z, PackedColour colour) {
    const std::uint64_t here = std::uint64_t{z} << 32 | colour;
    pixel = here > pixel ? here : pixel;
}

/// Inputs of a row of pixels.
struct PixelRow {
    const PackedColour *upper_left, *upper_right, *lower_left, *lower_right;
    const float *upper_left_q, *upper_right_q, *lower_left_q, *lower_right_q;
    const float* into;  ///< position in the cell, from the left
    float down;         ///< position in the cell, from above
    float z_per_q;
    float hole_q;  ///< drawn where there is no surface; 0: nothing is
    PackedColour background;
};

// Selects by masks, all bits or none: `?:` on values read here would become a branch and prevent vectors.
[[gnu::always_inline]] inline std::int32_t mask_of(bool is_so) {
    return -static_cast<std::int32_t>(is_so);
}
[[gnu::always_inline]] inline std::uint32_t chosen(std::int32_t mask, std::uint32_t value,
                                                   std::uint32_t other) {
    return other ^ (static_cast<std::uint32_t>(mask) & (value ^ other));
}
[[gnu::always_inline]] inline float chosen(std::int32_t mask, float value, float other) {
    return std::bit_cast<float>(
        chosen(mask, std::bit_cast<std::uint32_t>(value), std::bit_cast<std::uint32_t>(other)));
}

[[gnu::always_inline]] inline float greater_of(float a, float b) {
    return a > b ? a : b;
}

/// A channel of an interpolated colour, rounded.
[[gnu::always_inline]] inline std::uint32_t channel_of(PackedColour a, PackedColour other, PackedColour c,
                                                       float of_other, float of_c, int shift) {
    const auto at = static_cast<float>(static_cast<int>(a >> shift & 255U));
    const auto to_other = static_cast<float>(static_cast<int>(other >> shift & 255U)) - at;
    const auto to_c = static_cast<float>(static_cast<int>(c >> shift & 255U)) - at;
    const float mixed = at + of_other * to_other + of_c * to_c;
    return static_cast<std::uint32_t>(static_cast<int>(mixed + 0.5F)) << shift;
}

/// Uses raster.comp's arithmetic. A cell's diagonal runs from its upper left to its lower right corner.
[[gnu::always_inline]] inline void draw_row(const PixelRow& row, int pixels, PackedColour* __restrict colours,
                                            float* __restrict z) {
    const PixelRow from = row;
    const float down = from.down;
    for (int x = 0; x < pixels; ++x) {
        const float into = from.into[x];
        const std::int32_t is_right = mask_of(into >= down);
        const float right_of = into - down;
        const float of_other = chosen(is_right, right_of, -right_of), of_c = chosen(is_right, down, into);
        const float hole = from.hole_q;
        const float a_q = greater_of(from.upper_left_q[x], hole),
                    c_q = greater_of(from.lower_right_q[x], hole);
        const float other_q = greater_of(chosen(is_right, from.upper_right_q[x], from.lower_left_q[x]), hole);
        const PackedColour a = from.upper_left[x], c = from.lower_right[x];
        const PackedColour other = chosen(is_right, from.upper_right[x], from.lower_left[x]);
        const PackedColour colour = channel_of(a, other, c, of_other, of_c, 0) |
                                    channel_of(a, other, c, of_other, of_c, 8) |
                                    channel_of(a, other, c, of_other, of_c, 16) | 0xff000000U;
        const float nearness = (a_q + of_other * (other_q - a_q) + of_c * (c_q - a_q)) * from.z_per_q;
        // Branch-free: no hole (`triangle_has_hole`), and not in front of the near plane.
        const std::int32_t is_drawn =
            mask_of(a_q > 0.0F) & mask_of(other_q > 0.0F) & mask_of(c_q > 0.0F) & mask_of(nearness <= 1.0F);
        colours[x] = chosen(is_drawn, colour, from.background);
        z[x] = chosen(is_drawn, nearness, 0.0F);
    }
}

}  // namespace

struct LatticeRaster::Rows {
    LatticeRow upper, lower;
};

/// A thread's rows of the picture: draws all cells of the lattice visible there, row by row.
class LatticeRaster::Band {
public:
    Band(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera,
         const RowBand& band, std::uint64_t* pixels)
        : lattice_(lattice),
          edges_(edges),
          projection_(lattice, edges, camera),
          view_(rows_of(camera)),
          width_(camera.width),
          first_(band.first),
          last_(band.last - 1),
          height_(camera.height),
          is_turned_(!is_own_view(camera)),
          cut_ratio_(is_turned_ ? cut_ratio(lattice.step) : std::numeric_limits<float>::max()),
          pixels_(pixels) {}

    void draw(VectorUnit unit, Rows& rows) {
        if (lattice_.height == 0) return;  // before the first frame
        const auto all = [&](auto kind) __attribute__((always_inline)) {
            // Compilers generate poor code for 512-bit vectors.
            constexpr int n = std::min<int>(sizeof(typename decltype(kind)::type) / sizeof(float), 8);
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
    /// Whether a row of cells may be visible in this band.
    bool meets(const Rows& rows) const {
        if (!rows.upper.is_in_front || !rows.lower.is_in_front) return true;
        const int least = std::min(rows.upper.least_y, rows.lower.least_y),
                  most = std::max(rows.upper.most_y, rows.lower.most_y);
        if (least > most) return false;  // no valid vertices
        return first_pixel(least) <= last_ && last_pixel(most) >= first_;
    }

    template <int n>
    struct Cells {
        Corners<n> top_left, top_right, bottom_right, bottom_left;
    };

    /// Pixels that cells may cover: the first one, and how many follow to the right and down; negative if
    /// none.
    template <int n>
    struct Extent {
        Ints<n> first_x, first_y, beyond_x, beyond_y;
        Ints<n> is_large;  ///< too large for 32-bit products
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

    /// Draws n cells from (x, y) on.
    template <int n>
    [[gnu::always_inline]] void draw_cells(const Rows& rows, int x, int y) {
        using F = Floats<n>;
        using I = Ints<n>;
        const LatticeRow &up = rows.upper, &low = rows.lower;
        const F q00 = load<F>(&up.q[x]), q10 = load<F>(&up.q[x + 1]), q01 = load<F>(&low.q[x]),
                q11 = load<F>(&low.q[x + 1]);
        const I no_right = cut(q00, q10, q11, cut_ratio_), no_left = cut(q00, q11, q01, cut_ratio_);
        I is_drawn = ~(no_right & no_left);
        if (is_turned_ && lattice_.fills_gaps)
            fill_gaps<n>(x, y, no_right & (q10 != 0.0F), no_left & (q01 != 0.0F),
                         (q00 != 0.0F) & (q11 != 0.0F));
        if (or_of(is_drawn) == 0) return;
        Cells<n> cells{corners_of<n>(up, x), corners_of<n>(up, x + 1), corners_of<n>(low, x + 1),
                       corners_of<n>(low, x)};
        cells.top_right.x = no_right ? cells.top_left.x : cells.top_right.x;  // zero area: not drawn
        cells.top_right.y = no_right ? cells.top_left.y : cells.top_right.y;
        cells.bottom_left.x = no_left ? cells.top_left.x : cells.bottom_left.x;
        cells.bottom_left.y = no_left ? cells.top_left.y : cells.bottom_left.y;
        const I diagonal_starts = load<I>(&up.in_front[x]), diagonal_ends = load<I>(&low.in_front[x + 1]),
                right_is = load<I>(&up.in_front[x + 1]), left_is = load<I>(&low.in_front[x]);
        const I in_front = diagonal_starts & diagonal_ends & (right_is | no_right) & (left_is | no_left),
                partly = diagonal_starts | diagonal_ends | (right_is & ~no_right) | (left_is & ~no_left);
        const Extent<n> extent = extent_of(cells);
        // If part of a cell is behind the eye, its corners do not bound it on the screen.
        is_drawn &= partly & (~in_front | ((extent.beyond_x >= 0) & (extent.beyond_y >= 0)));
        if (or_of(is_drawn) == 0) return;
        if (const I large = is_drawn & (extent.is_large | ~in_front); or_of(large) != 0) {
            for (int k = 0; k < n; ++k)
                if (large[k] != 0) draw_cell(x + k, y, no_right[k] != 0, no_left[k] != 0);
            is_drawn &= ~large;
        }
        // plot_cells picks one of a cell's triangles for each pixel; a folded cell may cover a pixel with
        // both, so it is drawn twice.
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

    /// Fills the gaps among n cells from (x, y) on. `is_there`: the diagonal.
    template <int n>
    [[gnu::always_inline]] void fill_gaps(int x, int y, const Ints<n>& right, const Ints<n>& left,
                                          const Ints<n>& is_there) {
        if (or_of((right | left) & is_there) == 0) return;
        for (int k = 0; k < n; ++k) {
            if (is_there[k] == 0 || (right[k] | left[k]) == 0) continue;
            const glm::vec3 colour = gap_fill(lattice_, {x + k, y}, {lattice_.width, lattice_.height});
            const auto part = [&](int i, int j) { return FillCorner{corner(x + k + i, y + j).clip, colour}; };
            if (right[k] != 0) fill_one({part(0, 0), part(1, 0), part(1, 1)}, GAP_Z);
            if (left[k] != 0) fill_one({part(0, 0), part(1, 1), part(0, 1)}, GAP_Z);
        }
    }

    /// Draws each cell from its first pixel on: small cells one per lane, larger ones one after another.
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
        // Lanes without a cell point into this band, away from other threads' pixels.
        const I start = is_drawn ? first_y * width_ + first_x : I{} + first_ * width_;
        const I is_small = is_drawn & (beyond_x < most_pixels) & (beyond_y < most_pixels);
        if (const I others = is_drawn & ~is_small; or_of(others) != 0)
            for (int k = 0; k < n; ++k)
                if (others[k] != 0) plot_cell<n>(cells, k, start[k], beyond_x[k], beyond_y[k]);
        if (or_of(is_small) == 0) return;
        // A bit for each column and each line that any lane's cell has.
        const std::uint32_t extents =
            or_of(is_small & (17 | ((beyond_x > 0) & 2) | ((beyond_x > 1) & 4) | ((beyond_x > 2) & 8) |
                              ((beyond_y > 0) & 32) | ((beyond_y > 1) & 64) | ((beyond_y > 2) & 128)));
        plot_pixels<n, 1>(cells, start, is_small ? beyond_x : ~I{}, beyond_y & is_small,
                          std::bit_width(extents & 15U), std::bit_width(extents >> 4));
    }

    /// Draws one cell, with one column per lane.
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

    /// Draws pixels of cells: each lane starts at `start`, takes every `step`th column up to `beyond_x` more,
    /// none if that is negative, and `beyond_y` lines after the first.
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
        LanePlace<n> right_line(right), left_line(left);
        I line_start = start;
        for (int line = 0; line < lines; ++line) {
            LanePlace<n> in_right = right_line, in_left = left_line;
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
            line_start += (beyond_y > line) & width_;
        }
    }

    /// -1 if a triangle's corners are counterclockwise on the screen, otherwise 0.
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
        const Ints<n> bits = __builtin_bit_cast(Ints<n>, z) & is_here, seen = colour & is_here;
        std::memcpy(places.data(), &at, sizeof(at));
        std::memcpy(depths.data(), &bits, sizeof(bits));
        std::memcpy(colours.data(), &seen, sizeof(seen));
        for (std::size_t k = 0; k < n; ++k) keep_nearest(pixels_[places[k]], depths[k], colours[k]);
    }

    /// Draws a cell that is larger on the screen, or partly in front of the near plane.
    void draw_cell(int x, int y, bool no_right, bool no_left) {
        const FillCorner top_left = corner(x, y), bottom_right = corner(x + 1, y + 1);
        if (!no_right) fill_one({top_left, corner(x + 1, y), bottom_right}, 1);
        if (!no_left) fill_one({top_left, bottom_right, corner(x, y + 1)}, 1);
    }

    FillCorner corner(int i, int j) const {
        const glm::vec3 colour = gap_colour(lattice_, {i, j});
        if (const SurfaceEdges::Vertex* edge = edges_.at(i, j); edge != nullptr)
            return {view_clip(view_, edge->at_x, edge->at_y, edge->q), colour};
        const float q = is_turned_ || !lattice_.fills_gaps ? std::abs(gap_q(lattice_, {i, j}))
                                                           : std::max(gap_q(lattice_, {i, j}), HOLE_Q);
        return {view_clip(view_, static_cast<float>(i), static_cast<float>(j), q), colour};
    }

    void fill_one(const std::array<FillCorner, 3>& corners, float scale_of_z) {
        const auto plot = [&](int px, int py, float z, const glm::vec3& colour) {
            const glm::uvec3 byte(colour + 0.5F);
            if (z > 0.0F)
                keep_nearest(pixels_[static_cast<std::ptrdiff_t>(py) * width_ + px],
                             std::bit_cast<std::uint32_t>(z * scale_of_z),
                             pack_colour(byte.r, byte.g, byte.b));
        };
        fill_triangle(corners, width_, height_, plot, first_, last_);
    }

    const MappedLattice& lattice_;
    const SurfaceEdges& edges_;
    const RowProjection projection_;
    const ViewRows view_;
    const int width_, first_, last_, height_;
    const bool is_turned_;
    const float cut_ratio_;  // in the clip's own view only holes are cut
    std::uint64_t* const pixels_;
};

LatticeRaster::LatticeRaster(int threads, VectorUnit vectors)
    : unit_(vectors), bands_(threads), rows_(static_cast<std::size_t>(threads)) {}

LatticeRaster::~LatticeRaster() = default;

void LatticeRaster::draw(MappedLattice lattice, const SurfaceEdges& edges, const ViewCamera& camera,
                         std::span<const PackedColour> background, std::span<PackedColour> colours,
                         std::span<float> z) {
    if (!is_own_view(camera)) lattice.q = edges.eroded_q();
    pixels_.resize(pixel_count(camera.width, camera.height));
    const auto row_of = [&](int y) { return pixel_place(0, y, camera.width); };
    // One band per thread: threads write different rows, and each passes through the lattice once.
    const int rows_each = (camera.height + bands_.threads() - 1) / bands_.threads();
    bands_.for_each_band(camera.height, rows_each, [&](const RowBand& band) {
        std::fill(pixels_.begin() + static_cast<std::ptrdiff_t>(row_of(band.first)),
                  pixels_.begin() + static_cast<std::ptrdiff_t>(row_of(band.last)), std::uint64_t{0});
        Band(lattice, edges, camera, band, pixels_.data())
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

/// The cell and position of each pixel, for vertices at `subpixels_of(n)`, ascending.
template <class SubpixelsOf>
void OwnViewPicture::find_places(int vertices, int pixels, SubpixelsOf subpixels_of, Places& places) {
    places.cells.resize(static_cast<std::size_t>(pixels));
    places.into.resize(static_cast<std::size_t>(pixels));
    // A pixel centre on a cell's first side belongs to the cell; on the last cell's last side, too.
    const auto pixel_from = [pixels](int subpixels) {
        return std::clamp((subpixels + half_pixel - 1) >> 8, 0, pixels);
    };
    int from = subpixels_of(0);
    places.first = places.end = pixel_from(from);
    for (int n = 0; n + 1 < vertices; ++n) {
        const int to = subpixels_of(n + 1);
        const bool is_last = n + 2 == vertices && to > from;
        for (const int end = pixel_from(is_last ? to + 1 : to); places.end < end; ++places.end) {
            const auto p = static_cast<std::size_t>(places.end);
            places.cells[p] = n;
            places.into[p] = static_cast<float>(places.end * VIEW_SUBPIXELS + half_pixel - from) /
                             static_cast<float>(to - from);
        }
        from = to;
    }
}

bool OwnViewPicture::draws(const ViewCamera& camera) {
    const auto [x, y, z, w] = rows_of(camera);
    // Clip space is two units wide and high.
    constexpr float largest = 2.0F * RASTER_LARGE_CELL / VIEW_SUBPIXELS;
    return is_own_view(camera) && x.x * static_cast<float>(camera.width) < largest &&
           y.y * static_cast<float>(camera.height) < largest;
}

void OwnViewPicture::read_corners(const MappedLattice& lattice, int row, Corners& corners) const {
    const std::size_t start = pixel_place(0, row, lattice.width);
    const PackedColour* colours = lattice.colours + start;
    const float* q = lattice.q + start;
    for (auto* each : {&corners.left, &corners.right}) each->resize(columns_.cells.size());
    for (auto* each : {&corners.left_q, &corners.right_q}) each->resize(columns_.cells.size());
    for (auto x = static_cast<std::size_t>(columns_.first); x < static_cast<std::size_t>(columns_.end); ++x) {
        const int cell = columns_.cells[x];
        corners.left[x] = colours[cell];
        corners.right[x] = colours[cell + 1];
        corners.left_q[x] = q[cell];
        corners.right_q[x] = q[cell + 1];
    }
}

void OwnViewPicture::draw(const MappedLattice& lattice, const ViewCamera& camera,
                          std::span<const PackedColour> background, std::span<PackedColour> colours,
                          std::span<float> z) {
    const ViewRows view = rows_of(camera);
    const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    find_places(
        lattice.width, camera.width,
        [&](int i) { return view_subpixels(view_row(view.x, static_cast<float>(i), 0, 0), width); },
        columns_);
    find_places(
        lattice.height, camera.height,
        [&](int j) { return view_subpixels(view_row(view.y, 0, static_cast<float>(j), 0), height); }, rows_);
    const int first = columns_.first, end = columns_.end;
    int read = -1;  // the lattice row in upper_; lower_ holds the next
    for (int y = 0; y < camera.height; ++y) {
        PackedColour* const to = colours.data() + pixel_place(0, y, camera.width);
        float* const to_z = z.data() + pixel_place(0, y, camera.width);
        const PackedColour empty = background[static_cast<std::size_t>(y)];
        const bool is_there = y >= rows_.first && y < rows_.end;
        const int left = is_there ? first : camera.width, right = is_there ? end : camera.width;
        std::fill(to, to + left, empty);
        std::fill(to_z, to_z + left, 0.0F);
        std::fill(to + right, to + camera.width, empty);
        std::fill(to_z + right, to_z + camera.width, 0.0F);
        if (!is_there) continue;
        const int row = rows_.cells[static_cast<std::size_t>(y)];
        if (row != read) {
            std::swap(upper_, lower_);
            if (read < 0 || row != read + 1) read_corners(lattice, row, upper_);
            read_corners(lattice, row + 1, lower_);
            read = row;
        }
        const PixelRow pixels{upper_.left.data() + first,
                              upper_.right.data() + first,
                              lower_.left.data() + first,
                              lower_.right.data() + first,
                              upper_.left_q.data() + first,
                              upper_.right_q.data() + first,
                              lower_.left_q.data() + first,
                              lower_.right_q.data() + first,
                              columns_.into.data() + first,
                              rows_.into[static_cast<std::size_t>(y)],
                              view.z.w,
                              lattice.fills_gaps ? HOLE_Q : 0,
                              empty};
        const auto draw_pixels = [&](auto) __attribute__((always_inline)) {
            draw_row(pixels, end - first, to + first, to_z + first);
        };
        run_vectors(unit_, draw_pixels);
    }
}

}  // namespace touchable
