// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "shaders/cut_rule.h"
#include "tests/must.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/temporary_files.hpp"

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
    FramePair pair(double blend) const { return {{0, 0, &prev}, {1, 33'000'000, &next}, blend}; }

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

/// Calls look(codes, blend) for every coding, and for four places between its two frames.
template <class Look>
void for_every_coding(int width, int height, const Look& look) {
    for (const DepthCodingKind kind : {DepthCodingKind::linear, DepthCodingKind::inverse,
                                       DepthCodingKind::metric, DepthCodingKind::hue, DepthCodingKind::log})
        for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar})
            for (const bool near_is_high : {true, false})
                for (const bool heights : {false, true}) {
                    const Codes codes(coding_of(kind, semantics, near_is_high), width, height, heights);
                    for (const double blend : {0.0, 0.25, 0.5, 0.9}) look(codes, blend);
                }
}

/// Of 255, in the channel in which two colours differ most.
inline int colour_distance(PackedColour a, PackedColour b) {
    int most = 0;
    for (const unsigned shift : {0U, 8U, 16U})
        most = std::max(most,
                        std::abs(static_cast<int>(a >> shift & 255U) - static_cast<int>(b >> shift & 255U)));
    return most;
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

/// Two frames of a clip, built.
struct Shown {
    Scene scene;
    RawFrame raw_prev, raw_next;
    SurfaceFrame prev, next;

    FramePair pair(double blend = 0) const { return {{0, 0, &prev}, {1, 33'000'000, &next}, blend}; }
    HeightField field(double blend = 0) const { return {scene, pair(blend)}; }
    void build() {
        const auto builder = make_cpu_builder(scene);
        ASSERT_TRUE(builder->build(raw_prev, prev));
        ASSERT_TRUE(builder->build(raw_next, next));
    }
};

/// By words of --view, about the middle of what is shown.
inline ViewCamera view_of(const Shown& shown, const HeightField& field, const char* words, int width,
                          int height) {
    return make_view(*parse_viewpoint(words), shown.scene, subject_of(field).middle, width, height);
}

inline std::unique_ptr<Shown> shown_scene(const char* name, const SceneOptions& options) {
    auto made = make_scene(name, options);
    EXPECT_TRUE(made) << made.error().message;
    auto shown = std::make_unique<Shown>();
    shown->scene = (*made)->scene();
    shown->raw_prev = (*made)->frame(0);
    shown->raw_next = (*made)->frame(1);
    shown->build();
    return shown;
}

inline std::unique_ptr<Shown> shown_scene(const char* name, int width, int height) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.properties = std::string(name) == "globe";
    return shown_scene(name, options);
}

inline std::unique_ptr<Shown> shown_clip(const std::filesystem::path& folder,
                                         const std::filesystem::path& scene) {
    auto reader = open_clip(folder, scene);
    EXPECT_TRUE(reader) << reader.error().message;
    if (!reader) return nullptr;
    auto shown = std::make_unique<Shown>();
    shown->scene = (*reader)->scene();
    shown->raw_prev = **(*reader)->next();
    shown->raw_next = **(*reader)->next();
    shown->build();
    return shown;
}

inline std::unique_ptr<Shown> shown_recording(const char* name, const char* folder) {
    return shown_clip(real_data(folder), std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes" /
                                             (std::string(name) + ".json"));
}

inline std::unique_ptr<Shown> shown_stand_in(const char* name) {
    const TemporaryFolder folder;
    return shown_clip(folder.path(), write_stand_in(folder.path(), stand_in(name)));
}

/// Which tiles of a lattice of these q are worth drawing, by asking for every triangle.
inline ViewSurface::Tiles classify_tiles(int width, int height, const std::vector<float>& q) {
    const TileGrid grid = TileGrid::of(width, height);
    ViewSurface::Tiles tiles;
    auto at = [&](int x, int y) {
        return q[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    };
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            bool any_cut = false, any_shown = false;
            const int end_x = std::min((tx + 1) * TileGrid::cells, width - 1);
            const int end_y = std::min((ty + 1) * TileGrid::cells, height - 1);
            for (int y = ty * TileGrid::cells; y < end_y; ++y)
                for (int x = tx * TileGrid::cells; x < end_x; ++x)
                    for (const auto& [a, b, c] : {std::array{at(x, y), at(x + 1, y), at(x + 1, y + 1)},
                                                  std::array{at(x, y), at(x + 1, y + 1), at(x, y + 1)}}) {
                        any_cut = any_cut || triangle_is_cut(a, b, c);
                        any_shown = any_shown || !triangle_has_hole(a, b, c);
                    }
            if (!any_shown) continue;
            (any_cut ? tiles.mixed : tiles.whole)
                .push_back(static_cast<std::uint32_t>(ty * grid.tiles_x + tx));
        }
    return tiles;
}

/// Rows of 4 bytes a vertex, without what lies beyond the width; a GPU may have memory of its own.
template <class T>
std::vector<T> rows_in(const std::shared_ptr<GpuDevice>& gpu, const GpuLattice& lattice,
                       const GpuBuffer& buffer) {
    const auto back = must(GpuBuffer::create(*gpu, "back", buffer.bytes(), GpuMemory::readback));
    auto commands = must(GpuCommands::begin(gpu, "back"));
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.copy(buffer, 0, back, 0, back.bytes());
    must(must(std::move(commands).submit()).wait());
    std::vector<T> values;
    for (int y = 0; y < lattice.height; ++y) {
        const auto row = back.template mapped<T>().subspan(static_cast<std::size_t>(y * lattice.pitch),
                                                           static_cast<std::size_t>(lattice.width));
        values.insert(values.end(), row.begin(), row.end());
    }
    return values;
}

inline std::vector<float> q_by_kernel(const std::shared_ptr<GpuDevice>& gpu, GpuLattices& lattices,
                                      const HeightField& field, const FramePair& pair) {
    GpuLattice lattice;
    auto commands = must(GpuCommands::begin(gpu, "lattice"));
    must(lattices.record(commands, field, pair, lattice));
    must(must(std::move(commands).submit()).wait());
    return rows_in<float>(gpu, lattice, lattice.q);
}

/// With q_of(field), and classify_tiles of that.
inline ViewSurface make_view_surface(const HeightField& field, const PlaneView& colour,
                                     Lighting lighting = Lighting::full) {
    return make_view_surface(field, q_of(field), colour, lighting);
}

/// Every channel another, every pixel another.
struct ManyColours {
    ManyColours(int columns, int rows) : width(columns), height(rows) {
        for (int k = 0; k < width * height * 3; ++k) bytes.push_back(static_cast<std::uint8_t>(k * 89 % 251));
    }
    PackedColour at(std::size_t pixel) const {
        return pack_colour(bytes[3 * pixel], bytes[3 * pixel + 1], bytes[3 * pixel + 2]);
    }
    PlaneView view() const { return {bytes.data(), std::ptrdiff_t{3} * width, width, height, 1, 3}; }

    int width, height;
    std::vector<std::uint8_t> bytes;
};

/// `look(field, pair, colour)` for surfaces and pictures whose vertices are to be lit.
template <class Look>
void for_every_light(const Look& look) {
    for (const char* name : {"globe", "step", "noise"}) {
        SCOPED_TRACE(name);
        const auto shown = shown_scene(name, 171, 133);
        const ManyColours colours(171, 133);
        for (const double blend : {0.0, 0.4})
            for (const PlaneView& colour : {colours.view(), PlaneView{}})
                look(shown->field(blend), shown->pair(blend), colour);
    }
    const int sizes[][2] = {{1, 1},  {1, 9},  {9, 1},   {2, 2},    {3, 2},
                            {7, 65}, {8, 64}, {33, 17}, {24, 130}, {90, 70}};
    for (const auto& [width, height] : sizes)
        for (const bool heights : {false, true}) {
            const Codes codes(coding_of(DepthCodingKind::inverse, DepthSemantics::range, true), width, height,
                              heights);
            const FramePair pair = codes.pair(0.3);
            const ManyColours colours(width, height);
            look(HeightField(codes.scene, pair), pair, colours.view());
        }
}

/// Light of the vertices' q against `lit_colours`.
inline void expect_lit(const HeightField& field, std::vector<float> q, const PlaneView& colour,
                       const std::vector<PackedColour>& lit) {
    ViewSurface surface;
    surface.width = field.width();
    surface.height = field.height();
    surface.q = std::move(q);
    const std::vector<PackedColour> twin = lit_colours(field.scene().camera, surface, colour, Lighting::full);
    int worst = 0;
    for (std::size_t k = 0; k < twin.size(); ++k) {
        ASSERT_EQ(lit[k] >> 24, 255U) << "vertex " << k;
        worst = std::max(worst, colour_distance(lit[k], twin[k]));
    }
    EXPECT_LE(worst, 2) << surface.width << "x" << surface.height;
}

/// What painters draw, one triangle after the other, pixel by pixel: the definition that they are held
/// against. Pixel centres on the last cells' last sides are left out.
PicturePlanes plain_picture(const ViewSurface& surface, const ViewCamera& camera);
/// The same, with the background's colour where nothing is drawn.
PicturePlanes before_background(PicturePlanes planes);

}  // namespace touchable::test
