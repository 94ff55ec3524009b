// SPDX-License-Identifier: Apache-2.0
// A built frame as others want it: stored depth again, or floats (metres, normals, error bars).
//
// The normal of a pixel comes from the differences of q = 1 / planar depth to its neighbours, to the left and
// right, above and below, as (x, y, q) of a flat surface is flat. A neighbour beyond an edge is left out.
#include <cmath>
#include <limits>

#include "engine/base/vectors.hpp"
#include "engine/surface/inverse_depths.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

/// Between neighbours that are more pixel widths apart in depth is an edge: a surface so steep, 84 degrees,
/// shows a camera nothing but noise.
constexpr float widest_step = 10;
constexpr float no_number = std::numeric_limits<float>::quiet_NaN();

struct NormalLens {
    float fx, fy, cx, up;  // up: from the row to cy
};

/// By how much q changes from pixel to pixel, by its neighbours on both sides (0: none).
struct Slope {
    float change, known;  // known: 0 or 1
};
[[gnu::always_inline]] inline Slope slope(float before, float q, float after, float focal_length) {
    const auto side = [&](float a, float b) {
        const float least = std::min(a, b), step = std::abs(b - a);
        return least > 0 && step * focal_length <= widest_step * least ? 1.0F : 0.0F;
    };
    const float to_before = side(before, q), to_after = side(q, after), sides = to_before + to_after;
    const float known = sides > 0 ? 1.0F : 0.0F;
    return {(to_before * (q - before) + to_after * (after - q)) / (sides + (1 - known)), known};
}

/// `above`, `row`, `below`: with a 0 before the first pixel and behind the last one.
[[gnu::always_inline]] inline void tell_normals(int width, const NormalLens& lens,
                                                const float* __restrict above, const float* __restrict row,
                                                const float* __restrict below, float* __restrict nx,
                                                float* __restrict ny, float* __restrict nz) {
    for (int x = 0; x < width; ++x) {
        const float q = row[x];
        const Slope right = slope(row[x - 1], q, row[x + 1], lens.fx),
                    down = slope(above[x], q, below[x], lens.fy);
        const float known = right.known * down.known;
        const float x_part = -right.change * lens.fx, y_part = down.change * lens.fy;
        const float z_part = q + right.change * (lens.cx - static_cast<float>(x)) + down.change * lens.up;
        const float length = std::sqrt(x_part * x_part + y_part * y_part + z_part * z_part + (1 - known));
        const float scale = known > 0 ? 1 / length : no_number;
        nx[x] = x_part * scale;
        ny[x] = y_part * scale;
        nz[x] = z_part * scale;
    }
}

}  // namespace

InverseDepths::InverseDepths(const Camera& camera, int width) : camera_(camera) {
    for (int x = 0; x < width; ++x) u_.push_back(static_cast<float>(camera_.u(x)));
}

void InverseDepths::read_row(const SurfaceFrame& frame, int y, std::vector<float>& q) {
    know_codes(frame.coding);
    const std::size_t count = u_.size();
    q.resize(count);
    const std::uint16_t* const codes = frame.codes.data() + frame.index(0, y);
    for (std::size_t x = 0; x < count; ++x) q[x] = of_code_[codes[x]];
    const std::uint32_t* const valid = frame.validity_row(y);
    for (std::size_t x = 0; x < count; x += 32)
        if (const std::uint32_t word = valid[x / 32]; word != ~std::uint32_t{0})
            for (std::size_t k = x; k < std::min(count, x + 32); ++k)
                if (((word >> (k - x)) & 1U) == 0) q[k] = 0;
    if (frame.coding.semantics != DepthSemantics::range) return;
    const auto v = static_cast<float>(camera_.v(y)), apart = 1 + v * v;
    const float* const u = u_.data();
    float* const lengthened = q.data();
    for (std::size_t x = 0; x < count; ++x) lengthened[x] *= std::sqrt(apart + u[x] * u[x]);
}

void InverseDepths::know_codes(const DepthCoding& coding) {
    if (!of_code_.empty() && coding == coding_) return;
    coding_ = coding;
    of_code_.assign(65536, 0.0F);
    for (int code = coding.valid_min; code <= coding.valid_max; ++code)
        of_code_[static_cast<std::size_t>(code)] =
            static_cast<float>(1 / coding.depth(static_cast<std::uint16_t>(code)));
}

Scene filtered_scene(Scene scene) {
    const DepthCoding coding = FilterPlan(scene).coding();
    DepthCoding& stored = scene.depth = coding;
    if (stored.kind == DepthCodingKind::hue) stored.kind = DepthCodingKind::linear;  // in the code
    stored.least_sum = 0;
    derive_valid_range(stored);
    if (stored.is_valid(0) && !coding.is_valid(0)) {  // it stays what it was: no depth
        stored.invalid_codes[0] = 0;
        stored.invalid_code_count = 1;
        derive_valid_range(stored);
    }
    scene.depth_bits = 16;
    scene.stored = {};
    scene.float_scale = 0;
    scene.filter = {};
    return scene;
}

std::optional<std::uint16_t> code_of_no_depth(const DepthCoding& coding) {
    if (!coding.is_valid(0)) return std::uint16_t{0};
    if (coding.invalid_code_count > 0) return coding.invalid_codes[0];
    if (coding.valid_max < 65535) return static_cast<std::uint16_t>(coding.valid_max + 1);
    return std::nullopt;
}

void copy_codes(const SurfaceFrame& frame, std::uint16_t no_depth, std::uint16_t* to) {
    std::copy(frame.codes.begin(), frame.codes.end(), to);
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            if (!frame.is_valid(x, y)) to[frame.index(x, y)] = no_depth;
}

FilteredDepth::FilteredDepth(const Scene& scene)
    : camera_(scene.camera),
      metres_per_unit_(scene.metres_per_unit),
      depths_(std::make_unique<InverseDepths>(scene.camera, scene.width)) {}
FilteredDepth::~FilteredDepth() = default;

void FilteredDepth::metres(const SurfaceFrame& frame, const FloatRows& to) {
    if (metres_.empty() || frame.coding != coding_) {
        coding_ = frame.coding;
        metres_ = metres_of_codes(coding_, metres_per_unit_);
    }
    for (int y = 0; y < frame.height; ++y) {
        const std::uint16_t* const codes = frame.codes.data() + frame.index(0, y);
        float* const row = to.row(y);
        for (int x = 0; x < frame.width; ++x) row[x] = metres_[codes[x]];
        const std::uint32_t* const valid = frame.validity_row(y);
        for (int x = 0; x < frame.width; ++x)
            if (((valid[x >> 5] >> (x & 31)) & 1U) == 0) row[x] = no_number;
    }
}

void FilteredDepth::normals(const SurfaceFrame& frame, const FloatRows& to) {
    const auto width = static_cast<std::size_t>(frame.width);
    std::vector<float> read;
    std::array<std::vector<float>, 3> rows;
    for (auto& row : rows) row.assign(width + 2, 0.0F);
    const auto next_row = [&](int y) {
        std::swap(rows[0], rows[1]);
        std::swap(rows[1], rows[2]);
        if (y >= frame.height) return rows[2].assign(width + 2, 0.0F);
        depths_->read_row(frame, y, read);
        std::copy(read.begin(), read.end(), rows[2].begin() + 1);
    };
    std::vector<float> nx(width), ny(width), nz(width);
    next_row(0);
    for (int y = 0; y < frame.height; ++y) {
        next_row(y + 1);
        const NormalLens lens{static_cast<float>(camera_.fx), static_cast<float>(camera_.fy),
                              static_cast<float>(camera_.cx), static_cast<float>(camera_.cy - y)};
        run_vectors(
            usable_vector_units().front(), [&](auto) __attribute__((always_inline)) {
                tell_normals(frame.width, lens, rows[0].data() + 1, rows[1].data() + 1, rows[2].data() + 1,
                             nx.data(), ny.data(), nz.data());
            });
        float* at = to.row(y);
        for (std::size_t x = 0; x < width; ++x, at += 3) {
            at[0] = nx[x];
            at[1] = ny[x];
            at[2] = nz[x];
        }
    }
}

void FilteredDepth::error_degrees(const SurfaceFrame& frame, const FloatRows& to) const {
    const ErrorSigns& signs = frame.signs;
    std::vector<float> bars;
    for (const ErrorSigns::Block& block : signs.blocks)
        bars.push_back(static_cast<float>(signs.bar(block).degrees));
    for (int y = 0; y < frame.height; ++y) {
        float* const row = to.row(y);
        for (int x = 0; x < frame.width; ++x) {
            const ErrorSigns::Block* const block = frame.is_valid(x, y) ? signs.block_at(x, y) : nullptr;
            row[x] = block ? bars[static_cast<std::size_t>(block - signs.blocks.data())] : no_number;
        }
    }
}

}  // namespace touchable
