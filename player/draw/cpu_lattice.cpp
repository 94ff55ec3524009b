#include "player/draw/cpu_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "engine/base/vectors.hpp"
#include "player/draw/surface_unproject.hpp"
#include "shaders/blend_rule.h"
#include "shaders/cut_rule.h"

// Compiled without errno for square roots, which there are none of what is negative: the loops below become
// vectors by themselves.

namespace touchable {
namespace {

/// What a row of a frame is made of; heights: null where it has none.
struct FrameRow {
    FrameRow(const SurfaceFrame& frame, int y)
        : codes(frame.codes.data() + frame.index(0, y)),
          heights(frame.heights.empty() ? nullptr : frame.heights.data() + frame.index(0, y)),
          validity(frame.validity_row(y)) {}

    const std::uint16_t *codes, *heights;
    const std::uint32_t* validity;
};

/// Depths of a row, and 1 where they are valid, 0 elsewhere. Invalid ones are 1, so that nothing divides by
/// 0.
[[gnu::always_inline]] inline void depths_of_row(const FrameRow& row, const UnprojectTerms& terms,
                                                 float height_per_code, int width, float* depths,
                                                 float* valid) {
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
    if (height_per_code == 0.0F) return;
    for (int x = 0; x < width; ++x) {
        const float depth = depths[x] - height_per_code * static_cast<float>(row.heights[x]);
        depths[x] = valid[x] > 0.0F ? depth : 1.0F;
    }
}

/// Where there is nothing half-way, a pixel takes the state of the frame nearer in time.
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

/// `triangle_is_cut`, without a branch, which would keep the loop below from becoming vectors.
[[gnu::always_inline]] inline std::uint32_t cut(float q0, float q1, float q2) {
    float least = q0 < q1 ? q0 : q1, greatest = q0 < q1 ? q1 : q0;
    least = q2 < least ? q2 : least;
    greatest = q2 > greatest ? q2 : greatest;
    return static_cast<std::uint32_t>(!(least > 0.0F)) |
           static_cast<std::uint32_t>(greatest > CUT_RULE_RATIO * least);
}

/// A row of cells between two rows of q: 1 is added where a triangle is cut, 2 where one has no hole.
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

/// As they are.
void copy_colours(const LightTerms& terms, int first, int end, PackedColour* colours) {
    for (int y = first; y < end; ++y) {
        const std::uint8_t* rgb = terms.colour.row(y);
        PackedColour* const to = colours + static_cast<std::ptrdiff_t>(y) * terms.pitch;
        for (int x = 0; x < terms.width; ++x, rgb += 3) to[x] = pack_colour(rgb[0], rgb[1], rgb[2]);
    }
}

}  // namespace

int CpuLattices::usual_threads() {
    constexpr unsigned most = 4;  // more wait for memory
    return static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, most));
}

CpuLattices::CpuLattices(int threads, VectorUnit vectors)
    : unit_(vectors),
      bands_(threads),
      scratch_(static_cast<std::size_t>(threads)),
      light_rows_(static_cast<std::size_t>(threads)) {}

void CpuLattices::q_of(const HeightField& field, const FramePair& pair, std::vector<float>& q) {
    q.resize(static_cast<std::size_t>(field.width()) * static_cast<std::size_t>(field.height()));
    q_of(field, pair, q.data(), field.width());
}

void CpuLattices::q_of(const HeightField& field, const FramePair& pair, float* q, int pitch) {
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
                float* const row = q + static_cast<std::ptrdiff_t>(y) * pitch;
                q_of_row(depths, valid, u2_.data(), v * v, is_range, width, row);
                std::fill(row + width, row + pitch, 0.0F);
            }
        };
        run_vectors(unit_, rows);
    });
}

ViewTiles CpuLattices::tiles_of(int width, int height, const std::vector<float>& q) {
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
    ViewTiles tiles;
    for (std::size_t n = 0; n < classes_.size(); ++n)
        if ((classes_[n] & 2U) != 0)
            (classes_[n] == 3 ? tiles.mixed : tiles.whole).push_back(static_cast<std::uint32_t>(n));
    return tiles;
}

void CpuLattices::light(const HeightField& field, const float* q, int pitch, const PlaneView& colour,
                        Lighting lighting, PackedColour* colours, float cut_ratio) {
    const Scene& scene = field.scene();
    LightTerms terms{
        scene.camera, static_cast<float>(scene.depth.far), q, field.width(), field.height(), pitch, colour};
    terms.cut_ratio = cut_ratio;
    if (colour.empty())
        terms.usual = usual_q(terms.width, terms.height, [q, pitch](int x, int y) {
            return q[static_cast<std::ptrdiff_t>(y) * pitch + x];
        });
    const bool is_lit = colour.empty() || lighting == Lighting::lit;
    bands_.for_each_band(terms.height, TileGrid::cells, [&](const RowBand& band) {
        if (is_lit)
            light_rows_[static_cast<std::size_t>(band.thread)].light(terms, band.first, band.last, unit_,
                                                                     colours);
        else
            copy_colours(terms, band.first, band.last, colours);
    });
}

ViewSurface CpuLattices::surface_of(const HeightField& field, const FramePair& pair,
                                    const PlaneView& colour) {
    std::vector<float> q;
    if (SurfaceUnproject::has_codes(field, pair))
        q_of(field, pair, q);
    else
        q = touchable::q_of(field);
    ViewTiles tiles = tiles_of(field.width(), field.height(), q);
    return make_view_surface(field, std::move(q), std::move(tiles), colour);
}

}  // namespace touchable
