#include "player/draw/cpu_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "engine/base/vectors.hpp"
#include "shaders/cut_rule.h"
#include "shaders/surface_light.h"

// Compiled without errno and traps: the loops over a row become vectors by themselves. In them nothing is
// read under a condition, and functions of a normal take it by its coordinates.

namespace touchable {
namespace {

constexpr int margin = 4;  // columns of zeros beyond each end of a row
constexpr int reach = 2;   // normals are summed over so many vertices to each side
constexpr int sides = 2 * reach + 1;

/// What the normal of a triangle takes of the camera.
struct Lens {
    float fx, fy, cx, cy, unit, cut_ratio;
};

/// 1 where a triangle is drawn, 0 where it is cut: `triangle_is_cut` without a branch.
[[gnu::always_inline]] inline float drawn(float q0, float q1, float q2, float ratio) {
    float least = q0 < q1 ? q0 : q1, greatest = q0 < q1 ? q1 : q0;
    least = q2 < least ? q2 : least;
    greatest = q2 > greatest ? q2 : greatest;
    const float is_valid = least > 0.0F ? 1.0F : 0.0F;
    return greatest <= ratio * least ? is_valid : 0.0F;
}

/// By how much a triangle's normal is longer than (difference of q, ...), 0 where it is cut.
[[gnu::always_inline]] inline float weight(float q0, float q1, float q2, const Lens& lens) {
    const float is_drawn = drawn(q0, q1, q2, lens.cut_ratio), unit = lens.unit;
    const float volume = q0 * unit * (q1 * unit) * (q2 * unit);
    return is_drawn > 0.0F ? unit / (is_drawn > 0.0F ? volume : 1.0F) : 0.0F;
}

/// Normals of the triangles of a row of cells, right ones and left ones, as light.comp has them.
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

/// Of one coordinate: the sum at each vertex, of what the cells above have left in `above` and of those
/// below it, which leave there what they have for the next row.
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

/// What `light_on` says of each normal, into the place of its x.
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

/// `lit_colour`, of light that is not negative.
[[gnu::always_inline]] inline void shade_colours(const std::uint8_t* rgb, const float* light, int width,
                                                 PackedColour* __restrict colours) {
    for (int x = 0; x < width; ++x) {
        const float gain = 0.45F + 0.7F * light[x];
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

}  // namespace

LightRows::Row LightRows::row(int n) {
    float* const first = floats_.data() + 3 * static_cast<std::size_t>(n) * stride_ + margin;
    return {first, first + stride_, first + 2 * stride_};
}

void LightRows::light(const LightTerms& terms, int first, int end, VectorUnit unit, PackedColour* colours) {
    const int width = terms.width, height = terms.height;
    stride_ = static_cast<std::size_t>(width) + 2 * margin;
    floats_.assign(3 * (5 + sides) * stride_, 0.0F);
    const Row right = row(0), left = row(1), above = row(2), at_vertices = row(3), sum = row(4);
    const Camera& camera = terms.camera;
    const Lens lens{static_cast<float>(camera.fx),
                    static_cast<float>(camera.fy),
                    static_cast<float>(camera.cx),
                    static_cast<float>(camera.cy),
                    terms.farthest,
                    terms.cut_ratio};
    const auto q_row = [&](int y) { return terms.q + static_cast<std::ptrdiff_t>(y) * terms.pitch; };
    const auto along = [&](int y) { return row(5 + (y + sides) % sides); };

    const auto coordinates = [](const Row& from) { return std::array<float*, 3>{from.x, from.y, from.z}; };
    const auto rows = [&](auto) __attribute__((always_inline)) {
        // A row of cells ends the sums of the vertices on its upper side; with these the rows of vertices two
        // above them are done.
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
            PackedColour* const to = colours + static_cast<std::ptrdiff_t>(done) * terms.pitch;
            if (terms.colour.empty())
                shade_clay(q_row(done), terms.usual, sum.x, width, to);
            else
                shade_colours(terms.colour.row(done), sum.x, width, to);
        }
    };
    run_vectors(unit, rows);
}

}  // namespace touchable
