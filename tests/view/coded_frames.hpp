#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "player/draw/drawn_surface.hpp"

namespace touchable::test {

/// Two frames of every code there is, or nearly so, some pixels invalid.
struct Codes {
    Codes(const DepthCoding& coding, int width, int height, bool heights) {
        scene.width = width;
        scene.height = height;
        scene.camera = {0.9 * width, 1.1 * width, 0.4 * width, 0.7 * height};
        scene.depth = coding;
        derive_valid_range(scene.depth);
        scene.height_coding = {0.3 * coding.near, HeightUnits::world, 255};
        SplitMix64 random(3);
        for (SurfaceFrame* frame : {&prev, &next}) {
            frame->width = width;
            frame->height = height;
            frame->coding = scene.depth;
            frame->codes.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
            frame->validity.resize(static_cast<std::size_t>(frame->validity_words_per_row()) *
                                   static_cast<std::size_t>(height));
            frame->tiles.resize(static_cast<std::size_t>(TileGrid::of(width, height).tiles_x) *
                                static_cast<std::size_t>(TileGrid::of(width, height).tiles_y));
            if (heights) frame->heights.resize(frame->codes.size());
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) set(*frame, x, y, random);
            frame->vertices = std::make_unique<FilteredVertices>(*frame);
        }
    }
    void set(SurfaceFrame& frame, int x, int y, SplitMix64& random) {
        const DepthCoding& coding = scene.depth;
        const auto code = static_cast<std::uint16_t>(random.within(coding.valid_min, coding.valid_max + 1.0));
        if (!frame.heights.empty())
            frame.heights[frame.index(x, y)] = static_cast<std::uint8_t>(random.next());
        if (!coding.is_valid(code) || random.unit() < 0.1) return;
        frame.codes[frame.index(x, y)] = code;
        frame.validity[static_cast<std::size_t>(y * frame.validity_words_per_row() + x / 32)] |= 1U
                                                                                                 << (x % 32);
    }
    Scene scene;
    SurfaceFrame prev, next;
};

inline DepthCoding coding_of(DepthCodingKind kind, DepthSemantics semantics, bool near_is_high) {
    DepthCoding coding;
    coding.kind = kind;
    coding.semantics = semantics;
    coding.near_is_high = near_is_high;
    coding.near = 0.3;
    coding.far = 70;
    coding.scale = 0.001;
    if (kind == DepthCodingKind::log) coding.shift = 0.2;
    coding.code_max = kind == DepthCodingKind::hue ? 1535 : 65535;
    return coding;
}

/// Whether roundings may decide if a pixel's two depths are mixed.
inline bool is_at_the_gate(const HeightField& field, std::size_t pixel) {
    const auto width = static_cast<std::size_t>(field.width());
    auto [before, after] = field.vertices_of_frames(static_cast<std::int64_t>(pixel % width),
                                                    static_cast<std::int64_t>(pixel / width));
    const FieldVertex nearer{before.depth * (1 - 1e-4), before.valid},
        farther{before.depth * (1 + 1e-4), before.valid};
    return are_mixed(field, nearer, after) != are_mixed(field, farther, after);
}

/// q against those of its twin: the same pixels invalid, the others 1e-6 of the depth before height is taken
/// off, plus what that is of the depth after it.
inline void expect_close(const HeightField& field, const SurfaceFrame& prev, const std::vector<float>& twin,
                         const std::vector<float>& made) {
    const Scene& scene = field.scene();
    ASSERT_EQ(twin.size(), made.size());
    const double tallest = prev.heights.empty() ? 0 : largest_height(scene.height_coding, scene.depth);
    double worst = 0;
    std::size_t left_out = 0;
    for (std::size_t k = 0; k < twin.size(); ++k) {
        ASSERT_EQ(made[k] == 0.0F, twin[k] == 0.0F) << "pixel " << k;
        if (twin[k] == 0.0F) continue;
        if (field.blend() > 0 && is_at_the_gate(field, k)) {
            ++left_out;
            continue;
        }
        const double q = static_cast<double>(twin[k]);
        const double bound = 1e-6 * (1 + 2 * tallest * q);
        worst = std::max(worst, std::fabs(static_cast<double>(made[k]) / q - 1) / bound);
    }
    EXPECT_LE(worst, 1.0);
    EXPECT_LE(left_out, 1 + twin.size() / 200);
}

}  // namespace touchable::test
