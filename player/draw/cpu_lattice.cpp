// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/pictures.hpp"
#include "shaders/blend_rule.h"
#include "shaders/cut_rule.h"
#include "shaders/surface_light.h"

// Compiled without errno and floating-point traps, so that plain loops over a row are auto-vectorised. For
// that they read nothing conditionally, pass normals as coordinates, and take square roots of non-negative
// values only.
//
// CpuLattices makes q, tiles and light; SurfaceEdges erodes q and finds the vertices at edges; Decimation
// halves frames and colours.

namespace touchable {
namespace {

/// Input of lighting: q as in ViewSurface, and a colour at each vertex.
struct LightTerms {
    Camera camera;
    float farthest = 1;        ///< an upper bound of depth, scene units
    const float* q = nullptr;
    int width = 0, height = 0;
    PlaneView colour;    ///< RGB of 8 bits, of that size; or empty for clay
    float strength = 1;  ///< of the light on them
    UsualQ usual{};    ///< clay's coolest and warmest q
    float cut_ratio = CUT_RULE_RATIO;
};

constexpr int margin = 4;  // columns of zeros beyond each end of a row
constexpr int reach = 2;   // normals are summed over this many vertices to each side
constexpr int sides = 2 * reach + 1;

/// Camera terms of a triangle's normal.
struct Lens {
    float fx, fy, cx, cy, unit, cut_ratio;
};

/// 1 if a triangle is drawn, 0 if it is cut: `triangle_is_cut` without a branch.
[[gnu::always_inline]] inline float drawn(float q0, float q1, float q2, float ratio) {
    float least = q0 < q1 ? q0 : q1, greatest = q0 < q1 ? q1 : q0;
    least = q2 < least ? q2 : least;
    greatest = q2 > greatest ? q2 : greatest;
    const float is_valid = least > 0.0F ? 1.0F : 0.0F;
    return greatest <= ratio * least ? is_valid : 0.0F;
}

/// Ratio of a triangle's normal to its differences of q; 0 if it is cut.
[[gnu::always_inline]] inline float weight(float q0, float q1, float q2, const Lens& lens) {
    const float is_drawn = drawn(q0, q1, q2, lens.cut_ratio), unit = lens.unit;
    const float volume = q0 * unit * (q1 * unit) * (q2 * unit);
    return is_drawn > 0.0F ? unit / (is_drawn > 0.0F ? volume : 1.0F) : 0.0F;
}

/// Normals of the right and left triangles of a row of cells, as in light.comp.
[[gnu::always_inline]] inline void normals_of_cells(const float* upper, const float* lower, int cells,
                                                    float y, const Lens& lens, float* __restrict rx,
                                                    float* __restrict ry, float* __restrict rz,
                                                    float* __restrict lx, float* __restrict ly,
                                                    float* __restrict lz) {
    const float fx = lens.fx, fy = lens.fy, cx = lens.cx, v = y - lens.cy;
    for (int x = 0; x < cells; ++x) {
        const float q00 = upper[x], q10 = upper[x + 1], q01 = lower[x], q11 = lower[x + 1];
        const float u = static_cast<float>(x) - cx;
        const float right = weight(q00, q10, q11, lens), left = weight(q00, q01, q11, lens);
        const float right_x = q10 - q00, right_y = q11 - q10, left_x = q11 - q01, left_y = q01 - q00;
        rx[x] = -fx * right_x * right;
        ry[x] = fy * right_y * right;
        rz[x] = (q00 - right_x * u - right_y * v) * right;
        lx[x] = -fx * left_x * left;
        ly[x] = fy * left_y * left;
        lz[x] = (q00 - left_x * u - left_y * v) * left;
    }
}

/// Sums one coordinate of the normals at each vertex: `above` holds the sums of the cells above; it gets
/// those of the cells below, for the next row.
[[gnu::always_inline]] inline void sums_at_vertices(const float* right, const float* left, int width,
                                                    float* __restrict above, float* __restrict sums) {
    for (int x = 0; x < width; ++x) {
        const float before = right[x - 1], here = left[x];
        sums[x] = above[x] + (right[x] + before + here);
        above[x] = before + left[x - 1] + here;
    }
}

[[gnu::always_inline]] inline void sums_along(const float* values, int width, float* __restrict sums) {
    for (int x = 0; x < width; ++x)
        sums[x] = values[x - 2] + values[x - 1] + values[x] + values[x + 1] + values[x + 2];
}

[[gnu::always_inline]] inline void sums_across(const float* a, const float* b, const float* c, const float* d,
                                               const float* e, int width, float* __restrict sums) {
    for (int x = 0; x < width; ++x) sums[x] = a[x] + b[x] + c[x] + d[x] + e[x];
}

/// Writes `light_on` of each normal into its `xs`.
[[gnu::always_inline]] inline void light_of_normals(float* __restrict xs, const float* __restrict ys,
                                                    const float* __restrict zs, int width) {
    for (int k = 0; k < width; ++k) {
        const float squared = xs[k] * xs[k] + ys[k] * ys[k] + zs[k] * zs[k];
        const bool is_there = squared > 0.0F;
        const float per_length = 1.0F / std::sqrt(is_there ? squared : 1.0F);
        xs[k] = light_on(vec3(xs[k] * per_length, ys[k] * per_length, is_there ? zs[k] * per_length : 1.0F));
    }
}

[[gnu::always_inline]] inline std::uint32_t channel(float value) {
    const float least = value < 255.0F ? value : 255.0F;
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(least + 0.5F));
}

/// `lit_colour` for non-negative light.
[[gnu::always_inline]] inline void shade_colours(const std::uint8_t* rgb, const float* light, float strength,
                                                 int width, PackedColour* __restrict colours) {
    for (int x = 0; x < width; ++x) {
        const float gain = light_gain(light[x], strength);
        const auto r = static_cast<float>(rgb[3 * x]), g = static_cast<float>(rgb[3 * x + 1]),
                   b = static_cast<float>(rgb[3 * x + 2]);
        colours[x] = channel(r * gain) | channel(g * gain) << 8 | channel(b * gain) << 16 | 0xff000000U;
    }
}

void shade_clay(const float* q, const UsualQ& usual, const float* light, int width, PackedColour* colours) {
    const float per_range = 1 / std::max(usual.nearest - usual.farthest, 1e-30F);
    for (int x = 0; x < width; ++x) {
        const vec3 lit = lit_clay((q[x] - usual.farthest) * per_range, light[x]);
        colours[x] = pack_colour(channel(lit.x), channel(lit.y), channel(lit.z));
    }
}

/// Planes of a frame's row; heights: null without a height plane.
struct FrameRow {
    FrameRow(const SurfaceFrame& frame, int y)
        : codes(frame.codes.data() + frame.index(0, y)),
          heights(frame.heights.empty() ? nullptr : frame.heights.data() + frame.index(0, y)),
          validity(frame.validity_row(y)) {}

    const std::uint16_t *codes, *heights;
    const std::uint32_t* validity;
};

/// Depths of a row, and validity, 1 or 0. Invalid depths are 1, to avoid division by 0.
[[gnu::always_inline]] inline void depths_of_row(const FrameRow& row, const UnprojectTerms& terms,
                                                 float per_code, int width, float* depths, float* valid) {
    const UnprojectPush& push = terms.push;
    const bool from_top = terms.constants.is_from_top != 0;
    const int sign = from_top ? -1 : 1, offset = from_top ? static_cast<int>(push.code_max) : 0;
    const float base = push.base, step = push.step;
    for (int x = 0; x < width; ++x) valid[x] = static_cast<float>(row.validity[x >> 5] >> (x & 31) & 1U);
    for (int x = 0; x < width; ++x) {
        const float length = base + step * static_cast<float>(offset + sign * row.codes[x]);
        depths[x] = valid[x] > 0.0F ? length : 1.0F;
    }
    if (terms.constants.is_log != 0)
        for (int x = 0; x < width; ++x) {
            const auto m = static_cast<float>(offset + sign * row.codes[x]);
            depths[x] = valid[x] > 0.0F ? base + push.from_shift * grown(step * m, push.step_low * m) : 1.0F;
        }
    if (terms.constants.is_inverse != 0)
        for (int x = 0; x < width; ++x) depths[x] = 1.0F / depths[x] - push.shift;
    if (per_code == 0.0F) return;
    for (int x = 0; x < width; ++x) {
        const float depth = depths[x] - per_code * static_cast<float>(row.heights[x]);
        depths[x] = valid[x] > 0.0F ? depth : 1.0F;
    }
}

/// A pixel that is not interpolated takes the state of the frame nearer in time.
[[gnu::always_inline]] inline void mix_rows(const UnprojectPush& push, int width, const float* next_depths,
                                            const float* next_valid, float* depths, float* valid) {
    const float blend = push.blend, rest = push.rest, next_is_nearer = blend >= 0.5F ? 1.0F : 0.0F;
    for (int x = 0; x < width; ++x) {
        const float mixed = depths[x] * rest + next_depths[x] * blend;
        const bool mixes = depths_mix(depths[x], next_depths[x], push.reach);
        const float both = mixes ? valid[x] * next_valid[x] : 0.0F;
        const float nearer = next_is_nearer > 0.0F ? next_depths[x] : depths[x];
        depths[x] = both > 0.0F ? mixed : nearer;
        valid[x] = next_is_nearer > 0.0F ? next_valid[x] : valid[x];
    }
}

[[gnu::always_inline]] inline void q_of_row(const float* depths, const float* valid, const float* u2,
                                            float v2, bool is_range, int width, float* q) {
    if (!is_range) {
        for (int x = 0; x < width; ++x) q[x] = valid[x] / depths[x];
        return;
    }
    for (int x = 0; x < width; ++x) q[x] = valid[x] * std::sqrt(u2[x] + v2 + 1.0F) / depths[x];
}

/// `triangle_is_cut` without a branch, which would prevent vectorisation.
[[gnu::always_inline]] inline std::uint32_t cut(float q0, float q1, float q2) {
    float least = q0 < q1 ? q0 : q1, greatest = q0 < q1 ? q1 : q0;
    least = q2 < least ? q2 : least;
    greatest = q2 > greatest ? q2 : greatest;
    return static_cast<std::uint32_t>(!(least > 0.0F)) |
           static_cast<std::uint32_t>(greatest > CUT_RULE_RATIO * least);
}

/// Marks a row of cells between two rows of q: sets 1 if a triangle is cut, 2 if one has no hole.
[[gnu::always_inline]] inline void mark_row(const float* upper, const float* lower, int cells,
                                            std::uint32_t* marks) {
    for (int x = 0; x < cells; ++x) {
        const float q00 = upper[x], q10 = upper[x + 1], q01 = lower[x], q11 = lower[x + 1];
        const std::uint32_t right = cut(q00, q10, q11), left = cut(q00, q11, q01);
        const auto whole_diagonal =
                       static_cast<std::uint32_t>(q00 > 0.0F) & static_cast<std::uint32_t>(q11 > 0.0F),
                   whole_corner =
                       static_cast<std::uint32_t>(q10 > 0.0F) | static_cast<std::uint32_t>(q01 > 0.0F);
        marks[x] |= (right | left) + 2U * (whole_diagonal & whole_corner);
    }
}

/// Copies the colours of rows [first, end) unchanged.
void copy_colours(const LightTerms& terms, int first, int end, PackedColour* colours) {
    for (int y = first; y < end; ++y) {
        const std::uint8_t* rgb = terms.colour.row(y);
        PackedColour* const to = colours + static_cast<std::ptrdiff_t>(y) * terms.width;
        for (int x = 0; x < terms.width; ++x, rgb += 3) to[x] = pack_colour(rgb[0], rgb[1], rgb[2]);
    }
}

/// `edge_joins`, without a branch.
[[gnu::always_inline]] inline std::int32_t joins(float a, float b, float ratio) {
    const float least = a < b ? a : b, greatest = a < b ? b : a;
    return -(static_cast<std::int32_t>(least > 0.0F) & static_cast<std::int32_t>(greatest <= ratio * least));
}

/// `joins` of `count` pairs of vertices.
[[gnu::always_inline]] inline void join_row(const float* row, const float* beside, int count, float ratio,
                                            std::int32_t* joined) {
    for (int x = 0; x < count; ++x) joined[x] = joins(row[x], beside[x], ratio);
}

[[gnu::always_inline]] inline bool is_none(const std::int32_t* eight) {
    std::int32_t any = 0;
    for (int k = 0; k < 8; ++k) any |= eight[k];
    return any == 0;
}

/// The number of every second vertices, including one at or beyond the last vertex; it then takes that
/// vertex's values.
int half_of(int vertices) {
    return vertices / 2 + 1;
}

/// Halves the rows of a band, in a loop that is auto-vectorised.
template <class Values>
void halve_values(const Values& from, int from_width, int from_height, int width, VectorUnit unit,
                  const RowBand& band, Values& to) {
    const auto all = [&](auto) __attribute__((always_inline)) {
        std::uint16_t* __restrict values = to.data() + static_cast<std::ptrdiff_t>(band.first) * width;
        for (int y = band.first; y < band.last; ++y, values += width) {
            const std::uint16_t* __restrict row =
                from.data() + static_cast<std::ptrdiff_t>(std::min(2 * y, from_height - 1)) * from_width;
            for (int x = 0; x + 1 < width; ++x) values[x] = row[2 * x];
            values[width - 1] = row[from_width - 1];
        }
    };
    run_vectors(unit, all);
}

/// Compacts bits 0, 2, 4, ...
std::uint32_t even_bits(std::uint64_t bits) {
    bits &= 0x5555555555555555U;
    bits = (bits | bits >> 1) & 0x3333333333333333U;
    bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0fU;
    bits = (bits | bits >> 4) & 0x00ff00ff00ff00ffU;
    bits = (bits | bits >> 8) & 0x0000ffff0000ffffU;
    return static_cast<std::uint32_t>(bits | bits >> 16);
}

/// A vector of as many bytes as `Lanes` has 16-bit values.
template <class Lanes>
struct Bytes {
    typedef std::uint8_t Type __attribute__((vector_size(sizeof(Lanes) / 2)));
};
template <class Lanes>
[[gnu::always_inline]] inline Lanes load_bytes(const std::uint8_t* from) {
    typename Bytes<Lanes>::Type bytes;
    std::memcpy(&bytes, from, sizeof(bytes));
    return __builtin_convertvector(bytes, Lanes);
}
template <class Lanes>
[[gnu::always_inline]] inline void store_bytes(const Lanes& values, std::uint8_t* to) {
    const auto bytes = __builtin_convertvector(values, typename Bytes<Lanes>::Type);
    std::memcpy(to, &bytes, sizeof(bytes));
}

void halve_validity(const SurfaceFrame& from, const RowBand& band, SurfaceFrame& to) {
    const int words = to.validity_words_per_row(), from_words = from.validity_words_per_row();
    for (int y = band.first; y < band.last; ++y) {
        const int row = std::min(2 * y, from.height - 1);
        const std::uint32_t* bits = from.validity_row(row);
        std::uint32_t* const half = to.validity_row(y);
        for (int word = 0; word < words; ++word) {
            const std::uint64_t low = 2 * word < from_words ? bits[2 * word] : 0U,
                                high = 2 * word + 1 < from_words ? bits[2 * word + 1] : 0U;
            half[word] = even_bits(low | high << 32);
        }
        const int last = to.width - 1;
        half[last >> 5] &= ~(1U << (last & 31));
        half[last >> 5] |= std::uint32_t{from.is_valid(from.width - 1, row)} << (last & 31);
    }
}

/// Colours of the vertices of rows [first, end), with the CPU's vectors and the arithmetic of
/// shaders/light.h: the twin of `lit_colours`, to 2 of 255. A row's bits do not depend on the other rows or
/// on the vectors. `colours` points to row 0.
void light_rows(const LightTerms& terms, int first, int end, VectorUnit unit, std::vector<float>& scratch,
                PackedColour* colours) {
    const int width = terms.width, height = terms.height;
    const std::size_t stride = static_cast<std::size_t>(width) + 2 * margin;
    scratch.assign(3 * (5 + sides) * stride, 0.0F);
    /// A vector at each vertex or cell of a row, padded with zeros at both ends.
    struct Row {
        float *x, *y, *z;
    };
    const auto row = [&](int n) -> Row {
        float* const at = scratch.data() + 3 * static_cast<std::size_t>(n) * stride + margin;
        return {at, at + stride, at + 2 * stride};
    };
    const Row right = row(0), left = row(1), above = row(2), at_vertices = row(3), sum = row(4);
    const Camera& camera = terms.camera;
    const Lens lens{static_cast<float>(camera.fx),
                    static_cast<float>(camera.fy),
                    static_cast<float>(camera.cx),
                    static_cast<float>(camera.cy),
                    terms.farthest,
                    terms.cut_ratio};
    const auto q_row = [&](int y) { return terms.q + static_cast<std::ptrdiff_t>(y) * width; };
    const auto along = [&](int y) { return row(5 + (y + sides) % sides); };

    const auto coordinates = [](const Row& from) { return std::array<float*, 3>{from.x, from.y, from.z}; };
    const auto rows = [&](auto) __attribute__((always_inline)) {
        // A row of cells completes the sums of the vertices on its upper side, and these complete the vertex
        // row two above them.
        for (int y = first - reach - 1; y < end + reach; ++y) {
            const bool has_cells = y >= 0 && y + 1 < height;
            if (has_cells)
                normals_of_cells(q_row(y), q_row(y + 1), width - 1, static_cast<float>(y), lens, right.x,
                                 right.y, right.z, left.x, left.y, left.z);
            else
                std::fill(right.x - margin, above.x - margin, 0.0F);
            const Row newest = along(y);
            for (int axis = 0; axis < 3; ++axis) {
                const auto n = static_cast<std::size_t>(axis);
                float* const sums = coordinates(at_vertices)[n];
                sums_at_vertices(coordinates(right)[n], coordinates(left)[n], width, coordinates(above)[n],
                                 sums);
                sums_along(sums, width, coordinates(newest)[n]);
            }
            const int done = y - reach;
            if (done < first) continue;
            for (int axis = 0; axis < 3; ++axis) {
                const auto n = static_cast<std::size_t>(axis);
                sums_across(coordinates(along(done - 2))[n], coordinates(along(done - 1))[n],
                            coordinates(along(done))[n], coordinates(along(done + 1))[n],
                            coordinates(newest)[n], width, coordinates(sum)[n]);
            }
            light_of_normals(sum.x, sum.y, sum.z, width);
            PackedColour* const to = colours + static_cast<std::ptrdiff_t>(done) * width;
            if (terms.colour.empty())
                shade_clay(q_row(done), terms.usual, sum.x, width, to);
            else
                shade_colours(terms.colour.row(done), sum.x, terms.strength, width, to);
        }
    };
    run_vectors(unit, rows);
}

}  // namespace

int CpuLattices::usual_threads() {
    constexpr unsigned most = 4;  // more threads are limited by memory
    return static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, most));
}

CpuLattices::CpuLattices(int threads, VectorUnit vectors)
    : unit_(vectors), bands_(threads), scratch_(static_cast<std::size_t>(threads)) {}

void CpuLattices::q_of(const HeightField& field, const FramePair& pair, std::vector<float>& q) {
    if (!SurfaceUnproject::has_codes(field, pair)) {
        q = touchable::q_of(field);
        return;
    }
    q.resize(pixel_count(field.width(), field.height()));
    const UnprojectTerms terms = unproject_terms(field, pair);
    const UnprojectPush& push = terms.push;
    const bool is_pair = terms.constants.is_pair != 0, is_range = terms.constants.is_range != 0;
    const int width = field.width();
    const auto columns = static_cast<std::size_t>(width);
    u2_.resize(columns);
    for (int x = 0; x < width; ++x) {
        const float u = (static_cast<float>(x) - push.cx) * push.per_fx;
        u2_[static_cast<std::size_t>(x)] = u * u;
    }
    bands_.for_each_band(field.height(), TileGrid::cells, [&](const RowBand& band) {
        std::vector<float>& scratch = scratch_[static_cast<std::size_t>(band.thread)];
        scratch.resize(4 * columns);
        float *depths = scratch.data(), *valid = depths + columns, *next_depths = valid + columns,
              *next_valid = next_depths + columns;
        const auto rows = [&](auto) __attribute__((always_inline)) {
            for (int y = band.first; y < band.last; ++y) {
                depths_of_row(FrameRow(*pair.prev.frame, y), terms, push.height_per_code, width, depths,
                              valid);
                if (is_pair) {
                    depths_of_row(FrameRow(*pair.next.frame, y), terms, push.next_height_per_code, width,
                                  next_depths, next_valid);
                    mix_rows(push, width, next_depths, next_valid, depths, valid);
                }
                const float v = (static_cast<float>(y) - push.cy) * push.per_fy;
                q_of_row(depths, valid, u2_.data(), v * v, is_range, width,
                         q.data() + static_cast<std::ptrdiff_t>(y) * width);
            }
        };
        run_vectors(unit_, rows);
    });
}

ViewSurface::Tiles CpuLattices::tiles_of(int width, int height, const std::vector<float>& q) {
    constexpr int cells = TileGrid::cells;
    const TileGrid grid = TileGrid::of(width, height);
    const auto tile = [&](int tx, int ty) { return static_cast<std::size_t>(ty * grid.tiles_x + tx); };
    classes_.assign(tile(0, grid.tiles_y), 0);
    bands_.for_each_band(height - 1, cells, [&](const RowBand& band) {
        std::vector<std::uint32_t> marks(static_cast<std::size_t>(width));  // by column of cells
        const auto rows = [&](auto) __attribute__((always_inline)) {
            for (int y = band.first; y < band.last; ++y) {
                const float* upper = q.data() + static_cast<std::ptrdiff_t>(y) * width;
                mark_row(upper, upper + width, width - 1, marks.data());
                if (y + 1 < band.last && (y + 1) % cells != 0) continue;
                for (int x = 0; x < width - 1; ++x)
                    classes_[tile(x / cells, y / cells)] |=
                        static_cast<std::uint8_t>(marks[static_cast<std::size_t>(x)]);
                std::fill(marks.begin(), marks.end(), 0U);
            }
        };
        run_vectors(unit_, rows);
    });
    ViewSurface::Tiles tiles;
    for (std::size_t n = 0; n < classes_.size(); ++n)
        if ((classes_[n] & 2U) != 0)
            (classes_[n] == 3 ? tiles.mixed : tiles.whole).push_back(static_cast<std::uint32_t>(n));
    return tiles;
}

void CpuLattices::light(const HeightField& field, const std::vector<float>& q, const PlaneView& colour,
                        Lighting lighting, std::vector<PackedColour>& colours, float cut_ratio) {
    const Scene& scene = field.scene();
    LightTerms terms{scene.camera,
                     static_cast<float>(scene.depth.far),
                     q.data(),
                     field.width(),
                     field.height(),
                     colour,
                     light_strength(lighting)};
    terms.cut_ratio = cut_ratio;
    if (colour.empty())
        terms.usual = usual_q(terms.width, terms.height,
                              [&](int x, int y) { return q[pixel_place(x, y, terms.width)]; });
    colours.resize(q.size());
    const bool is_lit = colour.empty() || terms.strength > 0;
    bands_.for_each_band(terms.height, TileGrid::cells, [&](const RowBand& band) {
        if (is_lit)
            light_rows(terms, band.first, band.last, unit_, scratch_[static_cast<std::size_t>(band.thread)],
                       colours.data());
        else
            copy_colours(terms, band.first, band.last, colours.data());
    });
}

ViewSurface surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                       Lighting lighting) {
    std::vector<float> q;
    CpuLattices(CpuLattices::usual_threads()).q_of(field, pair, q);
    return make_view_surface(field, std::move(q), colour, lighting);
}

SurfaceEdges::SurfaceEdges(int threads, VectorUnit vectors)
    : unit_(vectors), bands_(threads), scratch_(static_cast<std::size_t>(threads)) {}

void SurfaceEdges::find(const EdgeLattice& lattice) {
    rows_.resize(static_cast<std::size_t>(lattice.height));
    for (auto& row : rows_) row.clear();
    eroded_.assign(lattice.q, lattice.q + static_cast<std::ptrdiff_t>(lattice.height) * lattice.pitch);
    if (lattice.width < 2 || lattice.height < 2) return;
    bands_.for_each_band(lattice.height, 16, [&](const RowBand& band) { erode_rows(lattice, band); });
    EdgeLattice eroded = lattice;
    eroded.q = eroded_.data();
    bands_.for_each_band(lattice.height, 16, [&](const RowBand& band) { find_rows(eroded, band); });
}

void SurfaceEdges::erode_rows(const EdgeLattice& lattice, const RowBand& band) {
    // Only vertices with a steep side, of any kind, are looked at one by one.
    const float flat = std::min(lattice.ratio, 1 + 0.7F * lattice.steepest);
    Scratch& of = scratch_[static_cast<std::size_t>(band.thread)];
    const int width = lattice.width;
    for (auto* each : {&of.right, &of.down, &of.upper_down})
        each->assign(static_cast<std::size_t>(width) + 1, -1);
    const auto all = [&](auto) __attribute__((always_inline)) {
        for (int y = std::max(band.first - 1, 0); y < band.last; ++y) {
            const float* row = lattice.q + static_cast<std::ptrdiff_t>(y) * lattice.pitch;
            of.down.swap(of.upper_down);
            if (y + 1 < lattice.height)
                join_row(row, row + lattice.pitch, width, flat, of.down.data());
            else
                std::fill(of.down.begin(), of.down.end(), -1);
            if (y < band.first) continue;
            join_row(row, row + 1, width - 1, flat, of.right.data() + 1);
            float* const to = eroded_.data() + static_cast<std::ptrdiff_t>(y) * lattice.pitch;
            const std::int32_t *right = of.right.data(), *down = of.down.data(),
                               *upper = of.upper_down.data();
            for (int x = 0; x < width; ++x)
                if ((right[x] & right[x + 1] & down[x] & upper[x]) == 0)
                    to[x] = edge_eroded_q(lattice, {x, y});
        }
    };
    run_vectors(unit_, all);
}

void SurfaceEdges::find_rows(const EdgeLattice& lattice, const RowBand& band) {
    Scratch& of = scratch_[static_cast<std::size_t>(band.thread)];
    const int width = lattice.width;
    // Padding at both ends counts as joined: a picture's border is no edge.
    for (auto* each : {&of.right, &of.down, &of.aslant, &of.upper_down, &of.upper_aslant, &of.candidates})
        each->assign(static_cast<std::size_t>(width) + 1, -1);
    const auto all = [&](auto) __attribute__((always_inline)) {
        const auto look_down = [&](int y) __attribute__((always_inline)) {
            if (y < 0 || y + 1 >= lattice.height) {
                std::fill(of.down.begin(), of.down.end(), -1);
                std::fill(of.aslant.begin(), of.aslant.end(), -1);
                return;
            }
            const float* row = lattice.q + static_cast<std::ptrdiff_t>(y) * lattice.pitch;
            const float* lower = row + lattice.pitch;
            join_row(row, lower, width, lattice.ratio, of.down.data());
            join_row(row, lower + 1, width - 1, lattice.ratio, of.aslant.data() + 1);
        };
        look_down(band.first - 1);
        for (int y = band.first; y < band.last; ++y) {
            of.down.swap(of.upper_down);
            of.aslant.swap(of.upper_aslant);
            look_down(y);
            const float* row = lattice.q + static_cast<std::ptrdiff_t>(y) * lattice.pitch;
            join_row(row, row + 1, width - 1, lattice.ratio, of.right.data() + 1);
            std::int32_t *candidates = of.candidates.data(), any = 0;
            // right[x] and aslant[x] are pairs that end at column x; those from x on are at [x + 1].
            const std::int32_t *right = of.right.data(), *down = of.down.data(), *aslant = of.aslant.data(),
                               *upper_down = of.upper_down.data(), *upper_aslant = of.upper_aslant.data();
            for (int x = 0; x < width; ++x) {
                const std::int32_t is_there = -static_cast<std::int32_t>(row[x] > 0.0F);
                candidates[x] = is_there & ~(right[x] & right[x + 1] & down[x] & upper_down[x] &
                                             aslant[x + 1] & upper_aslant[x]);
                any |= candidates[x];
            }
            if (any == 0) continue;
            auto& found = rows_[static_cast<std::size_t>(y)];
            for (int x = 0; x < width; ++x) {
                // Skips eight at a time, as most are no candidates.
                while (x + 8 <= width && is_none(candidates + x)) x += 8;
                if (x == width || candidates[x] == 0) continue;
                const EdgeMove move = edge_move(lattice, {x, y});
                if (move.by == ivec2(0, 0) && move.q == row[x]) continue;
                constexpr float step = 1.0F / EDGE_UNIT;
                found.push_back({x, static_cast<float>(x) + step * static_cast<float>(move.by.x),
                                 static_cast<float>(y) + step * static_cast<float>(move.by.y), move.q});
            }
        }
    };
    run_vectors(unit_, all);
}

std::span<const SurfaceEdges::Vertex> SurfaceEdges::row(int y) const {
    if (rows_.empty()) return {};
    return rows_[static_cast<std::size_t>(y)];
}

const SurfaceEdges::Vertex* SurfaceEdges::at(int x, int y) const {
    const auto vertices = row(y);
    const auto found = std::ranges::lower_bound(vertices, x, {}, &Vertex::x);
    return found != vertices.end() && found->x == x ? &*found : nullptr;
}

void Decimation::halve_frame(const SurfaceFrame& from, SurfaceFrame& to) {
    to.width = half_of(from.width);
    to.height = half_of(from.height);
    to.coding = from.coding;
    const std::size_t vertices = pixel_count(to.width, to.height);
    const bool has_heights = !from.heights.empty();
    to.codes.resize(vertices);
    to.heights.resize(has_heights ? vertices : 0);
    to.validity.resize(static_cast<std::size_t>(to.validity_words_per_row()) *
                       static_cast<std::size_t>(to.height));
    bands_.for_each_band(to.height, 1, [&](const RowBand& band) {
        halve_values(from.codes, from.width, from.height, to.width, unit_, band, to.codes);
        if (has_heights)
            halve_values(from.heights, from.width, from.height, to.width, unit_, band, to.heights);
        halve_validity(from, band, to);
    });
    if (!to.vertices) to.vertices = std::make_unique<FilteredVertices>(to);
}

const SurfaceFrame* Decimation::decimated_frame(const SurfaceFrame& frame, int step, Halves& halves) {
    const SurfaceFrame* made = &frame;
    for (int halvings = 0; 1 << halvings < step; ++halvings) {
        SurfaceFrame& half = halves[static_cast<std::size_t>(halvings % 2)];
        halve_frame(*made, half);
        made = &half;
    }
    return made;
}

/// Weights 1 2 1 across and down around every second pixel: no shift, and little aliasing.
void Decimation::halve_colour(const PlaneView& from, std::vector<std::uint8_t>& to) {
    const int width = half_of(from.width), height = half_of(from.height);
    to.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    bands_.for_each_band(height, 1, [&](const RowBand& band) {
        Scratch& of_thread = scratch_[static_cast<std::size_t>(band.thread)];
        for (int y = band.first; y < band.last; ++y)
            halve_colour_row(from, y, of_thread, to.data() + 3 * static_cast<std::ptrdiff_t>(width) * y);
    });
}

void Decimation::halve_colour_row(const PlaneView& from, int y, Scratch& of_thread, std::uint8_t* out) const {
    const int row_bytes = 3 * from.width, width = half_of(from.width);
    const auto row = [&](int at) { return from.row(std::clamp(at, 0, from.height - 1)); };
    const std::uint8_t *upper = row(2 * y - 1), *middle = row(2 * y), *lower = row(2 * y + 1);
    // One pixel before the first, and two after the last.
    of_thread.sums.resize(static_cast<std::size_t>(row_bytes) + 9);
    of_thread.means.resize(static_cast<std::size_t>(row_bytes) + 6);
    std::uint16_t* const sums = of_thread.sums.data() + 3;
    std::uint8_t* const means = of_thread.means.data();
    const auto all = [&](auto kind) __attribute__((always_inline)) {
        using Lanes = typename decltype(kind)::type;
        constexpr int n = lane_count<Lanes>;
        int k = 0;
        for (; k + n <= row_bytes; k += n)
            store_lanes<Lanes>(load_bytes<Lanes>(upper + k) + 2 * load_bytes<Lanes>(middle + k) +
                                   load_bytes<Lanes>(lower + k),
                               sums + k);
        for (; k < row_bytes; ++k) sums[k] = static_cast<std::uint16_t>(upper[k] + 2 * middle[k] + lower[k]);
        for (int channel = 0; channel < 3; ++channel) {
            sums[channel - 3] = sums[channel];
            sums[row_bytes + channel] = sums[row_bytes + 3 + channel] = sums[row_bytes - 3 + channel];
        }
        for (k = 0; k + n <= row_bytes + 3; k += n)
            store_bytes<Lanes>((load_lanes<Lanes>(sums + k - 3) + 2 * load_lanes<Lanes>(sums + k) +
                                load_lanes<Lanes>(sums + k + 3) + 8) >>
                                   4,
                               means + k);
        for (; k < row_bytes + 3; ++k)
            means[k] = static_cast<std::uint8_t>((sums[k - 3] + 2 * sums[k] + sums[k + 3] + 8) >> 4);
    };
    run_vectors(unit_, all);
    // Copies four bytes for three: the fourth is overwritten by the next pixel.
    for (int x = 0; x + 1 < width; ++x) std::memcpy(out + 3 * x, means + 6 * x, 4);
    std::memcpy(out + 3 * (width - 1), means + 6 * (width - 1), 3);
}

void Decimation::make(const HeightField& field, const FramePair& pair, const PlaneView& colour, int step) {
    pair_ = pair;
    pair_.prev.frame = decimated_frame(*pair.prev.frame, step, prev_);
    pair_.next.frame = pair.next.frame == pair.prev.frame ? pair_.prev.frame
                                                          : decimated_frame(*pair.next.frame, step, next_);
    scene_ = field.scene();
    scene_.width = pair_.prev.frame->width;
    scene_.height = pair_.prev.frame->height;
    for (double* const each : {&scene_.camera.fx, &scene_.camera.fy, &scene_.camera.cx, &scene_.camera.cy})
        *each /= step;
    field_.emplace(scene_, pair_);
    colour_ = colour;
    if (colour.empty()) return;
    for (int halves = 0; 1 << halves < step; ++halves) {
        std::vector<std::uint8_t>& half = half_colours_[halves % 2];
        halve_colour(colour_, half);
        const int width = half_of(colour_.width);
        colour_ = {half.data(), std::ptrdiff_t{3} * width, width, half_of(colour_.height), 1, 3};
    }
}

}  // namespace touchable
