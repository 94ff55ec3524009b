#include "player/draw/surface_edges.hpp"

#include <algorithm>
#include <cstddef>

#include "engine/base/vectors.hpp"

// Compiled without traps: the loops over a row's vertices become vectors by themselves.

namespace touchable {
namespace {

/// `edge_joins`, without a branch.
[[gnu::always_inline]] inline std::int32_t joins(float a, float b, float ratio) {
    const float least = a < b ? a : b, greatest = a < b ? b : a;
    return -(static_cast<std::int32_t>(least > 0.0F) & static_cast<std::int32_t>(greatest <= ratio * least));
}

/// Of `count` vertices and those beside them.
[[gnu::always_inline]] inline void join_row(const float* row, const float* beside, int count, float ratio,
                                            std::int32_t* joined) {
    for (int x = 0; x < count; ++x) joined[x] = joins(row[x], beside[x], ratio);
}

[[gnu::always_inline]] inline bool is_none(const std::int32_t* eight) {
    std::int32_t any = 0;
    for (int k = 0; k < 8; ++k) any |= eight[k];
    return any == 0;
}

}  // namespace

SurfaceEdges::SurfaceEdges(int threads, VectorUnit vectors)
    : unit_(vectors), bands_(threads), scratch_(static_cast<std::size_t>(threads)) {}

void SurfaceEdges::find(const float* q, int width, int height, int pitch, float cut_ratio, bool are_values) {
    rows_.resize(static_cast<std::size_t>(height));
    for (auto& row : rows_) row.clear();
    if (width < 2 || height < 2) return;
    const EdgeLattice lattice{q, width, height, pitch, cut_ratio};
    bands_.for_each_band(height, 16, [&](const RowBand& band) { find_rows(lattice, are_values, band); });
}

void SurfaceEdges::find_rows(const EdgeLattice& lattice, bool are_values, const RowBand& band) {
    Scratch& of = scratch_[static_cast<std::size_t>(band.thread)];
    const int width = lattice.width;
    // Before the first vertex and beyond the last everything is one surface: a picture's border is no edge.
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
            // [x] of right and aslant is the pair that ends at column x: of a cell's left vertex, [x + 1].
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
                // Most are none: eight at a time.
                while (x + 8 <= width && is_none(candidates + x)) x += 8;
                if (x == width || candidates[x] == 0) continue;
                const EdgeMove move = edge_move(lattice, {x, y});
                const int shade = are_values ? EDGE_UNIT : move.shade;
                if (move.by == ivec2(0, 0) && move.q == row[x] && shade == EDGE_UNIT) continue;
                constexpr float step = 1.0F / EDGE_UNIT;
                found.push_back({x, static_cast<float>(x) + step * static_cast<float>(move.by.x),
                                 static_cast<float>(y) + step * static_cast<float>(move.by.y), move.q,
                                 step * static_cast<float>(shade)});
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
    const auto found = std::lower_bound(vertices.begin(), vertices.end(), x,
                                        [](const Vertex& vertex, int column) { return vertex.x < column; });
    return found != vertices.end() && found->x == x ? &*found : nullptr;
}

}  // namespace touchable
