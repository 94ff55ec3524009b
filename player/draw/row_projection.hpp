#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "player/draw/lattice_row.hpp"
#include "player/draw/surface_edges.hpp"
#include "player/draw/triangle_lanes.hpp"
#include "player/draw/view_camera.hpp"
#include "player/draw/view_rows.hpp"

namespace touchable {

/// n vertices of a row from x on, as corners of cells.
template <int n>
[[gnu::always_inline]] inline Corners<n> corners_of(const LatticeRow& row, int x) {
    using F = Floats<n>;
    using I = Ints<n>;
    return {load<I>(&row.x[x]),   load<I>(&row.y[x]),     load<F>(&row.z[x]),   load<F>(&row.share[x]),
            load<F>(&row.red[x]), load<F>(&row.green[x]), load<F>(&row.blue[x])};
}

/// Brings rows of a lattice's vertices to the screen of a camera, n vertices at a time. Compiled as
/// triangle_lanes.hpp wants it.
class RowProjection {
public:
    RowProjection(const MappedLattice& lattice, const SurfaceEdges& edges, const ViewCamera& camera)
        : edges_(edges),
          view_(rows_of(camera)),
          q_(lattice.q),
          colours_(lattice.colours),
          width_(lattice.width),
          pitch_(lattice.pitch),
          screen_width_(camera.width),
          screen_height_(camera.height) {}

    /// Row y. Beyond the width follow vertices without a surface.
    template <int n>
    [[gnu::always_inline]] void project(int y, LatticeRow& row) const {
        using F = Floats<n>;
        using I = Ints<n>;
        const auto count = static_cast<std::size_t>(width_);
        const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * pitch_;
        row.resize((count + n) / n * n + n);
        std::memcpy(row.q.data(), q_ + start, count * sizeof(float));
        std::fill(row.q.begin() + static_cast<std::ptrdiff_t>(count), row.q.end(), 0.0F);
        std::memcpy(row.colours.data(), colours_ + start, count * sizeof(PackedColour));
        const F at = F{} + static_cast<float>(y);
        I least_y = I{} + std::numeric_limits<std::int32_t>::max(), most_y = ~least_y, in_front = ~I{};
        F column = lane_numbers<n>();
        for (std::size_t i = 0; i < count; i += n, column += static_cast<float>(n)) {
            const F q = load<F>(&row.q[i]);
            const F w = clip(view_.w, column, at, q), z = clip(view_.z, column, at, q), share = 1.0F / w;
            const I screen_y =
                        subpixels<n>(clip(view_.y, column, at, q) / w, static_cast<float>(screen_height_)),
                    is_in_front = w - z >= 0.0F, colour = load<I>(&row.colours[i]);
            store(subpixels<n>(clip(view_.x, column, at, q) / w, static_cast<float>(screen_width_)),
                  &row.x[i]);
            store(screen_y, &row.y[i]);
            store(is_in_front, &row.in_front[i]);
            store(z / w, &row.z[i]);
            store(share, &row.share[i]);
            store(__builtin_convertvector(colour & 255, F) * share, &row.red[i]);
            store(__builtin_convertvector(colour >> 8 & 255, F) * share, &row.green[i]);
            store(__builtin_convertvector(colour >> 16 & 255, F) * share, &row.blue[i]);
            const I is_there = q > 0.0F;
            least_y = (is_there & (screen_y < least_y)) ? screen_y : least_y;
            most_y = (is_there & (screen_y > most_y)) ? screen_y : most_y;
            in_front &= is_in_front | ~is_there;
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
    /// Vertices that are not drawn at their pixel to where they are, n at a time; q stays, by which triangles
    /// are cut.
    template <int n>
    [[gnu::always_inline]] void move_edges(int y, LatticeRow& row) const {
        using F = Floats<n>;
        using I = Ints<n>;
        const std::span<const SurfaceEdges::Vertex> edges = edges_.row(y);
        for (std::size_t first = 0; first < edges.size(); first += n) {
            const std::size_t count = std::min<std::size_t>(n, edges.size() - first);
            F column{}, at{}, q{}, light{};
            I colour{};
            for (std::size_t k = 0; k < n; ++k) {
                const SurfaceEdges::Vertex& edge = edges[first + std::min(k, count - 1)];
                column[k] = edge.at_x;
                at[k] = edge.at_y;
                q[k] = edge.q;
                light[k] = edge.light;
                colour[k] = static_cast<std::int32_t>(row.colours[static_cast<std::size_t>(edge.x)]);
            }
            const F w = clip(view_.w, column, at, q), z = clip(view_.z, column, at, q), share = 1.0F / w;
            const I screen_x =
                        subpixels<n>(clip(view_.x, column, at, q) / w, static_cast<float>(screen_width_)),
                    screen_y =
                        subpixels<n>(clip(view_.y, column, at, q) / w, static_cast<float>(screen_height_)),
                    in_front = w - z >= 0.0F;
            const F nearness = z / w, red = __builtin_convertvector(colour & 255, F) * light * share,
                    green = __builtin_convertvector(colour >> 8 & 255, F) * light * share,
                    blue = __builtin_convertvector(colour >> 16 & 255, F) * light * share;
            for (std::size_t k = 0; k < count; ++k) {
                const auto i = static_cast<std::size_t>(edges[first + k].x);
                row.x[i] = screen_x[k];
                row.y[i] = screen_y[k];
                row.in_front[i] = in_front[k];
                row.z[i] = nearness[k];
                row.share[i] = share[k];
                row.red[i] = red[k];
                row.green[i] = green[k];
                row.blue[i] = blue[k];
                row.least_y = std::min(row.least_y, screen_y[k]);
                row.most_y = std::max(row.most_y, screen_y[k]);
                row.is_in_front = row.is_in_front && in_front[k] != 0;
            }
        }
    }

    const SurfaceEdges& edges_;
    const ViewRows view_;
    const float* const q_;
    const PackedColour* const colours_;
    const int width_, pitch_, screen_width_, screen_height_;
};

}  // namespace touchable
