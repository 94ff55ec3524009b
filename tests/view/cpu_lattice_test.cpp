#include "player/draw/cpu_painting.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/surface/surface_builder.hpp"
#include "shaders/cut_rule.h"
#include "tests/view/coded_frames.hpp"
#include "tests/view/many_colours.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// Against the twins, and the same bits with any vectors and threads.
void compare(const Scene& scene, const SurfaceFrame& prev, const SurfaceFrame& next, double blend) {
    FramePair pair;
    pair.prev = {0, 0, &prev};
    pair.next = {1, 1'000'000, &next};
    pair.blend = blend;
    const HeightField field(scene, pair);
    std::vector<float> first;
    for (const VectorUnit unit : usable_vector_units())
        for (const int threads : {1, 3}) {
            CpuLattices lattices(threads, unit);
            std::vector<float> q;
            lattices.q_of(field, pair, q);
            if (first.empty()) first = q;
            ASSERT_EQ(q, first) << threads << " threads";
            EXPECT_EQ(lattices.tiles_of(scene.width, scene.height, q),
                      classify_tiles(scene.width, scene.height, q));
        }
    expect_close(field, prev, q_of(field), first);
}

/// Light of the same q against `lit_colours`, and the same bits with any vectors and threads.
void compare_light(const HeightField& field, const FramePair& pair, const PlaneView& colour) {
    ViewSurface surface;
    surface.width = field.width();
    surface.height = field.height();
    CpuLattices(1).q_of(field, pair, surface.q);
    const int pitch = surface.width + 5;
    std::vector<float> q(static_cast<std::size_t>(pitch * surface.height), NAN);
    CpuLattices(2).q_of(field, pair, q.data(), pitch);
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < pitch; ++x)
            ASSERT_EQ(q[static_cast<std::size_t>(y * pitch + x)],
                      x < surface.width ? surface.q[surface.index(x, y)] : 0.0F);
    const std::vector<PackedColour> twin = lit_colours(field.scene().camera, surface, colour);
    std::vector<PackedColour> first;
    for (const VectorUnit unit : usable_vector_units())
        for (const int threads : {1, 3}) {
            std::vector<PackedColour> lit(q.size(), 7);
            CpuLattices(threads, unit).light(field, q.data(), pitch, colour, Lighting::lit, lit.data());
            if (first.empty()) first = lit;
            ASSERT_EQ(lit, first) << threads << " threads";
        }
    int worst = 0;
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < pitch; ++x) {
            const PackedColour lit = first[static_cast<std::size_t>(y * pitch + x)];
            if (x >= surface.width) {
                ASSERT_EQ(lit, 7U) << "beyond the width";
                continue;
            }
            const PackedColour wanted = twin[surface.index(x, y)];
            ASSERT_EQ(lit >> 24, 255U);
            for (const unsigned shift : {0U, 8U, 16U})
                worst = std::max(worst, std::abs(static_cast<int>(lit >> shift & 255U) -
                                                 static_cast<int>(wanted >> shift & 255U)));
        }
    EXPECT_LE(worst, 2) << surface.width << "x" << surface.height;
}

TEST(CpuLattices, LightAsTheirTwin) {
    for (const char* name : {"globe", "step", "noise"}) {
        SCOPED_TRACE(name);
        const auto shown = shown_scene(name, 171, 133);
        const ManyColours colours(171, 133);
        for (const double blend : {0.0, 0.4}) {
            compare_light(shown->field(blend), shown->pair(blend), colours.view());
            compare_light(shown->field(blend), shown->pair(blend), {});
        }
    }
}

TEST(CpuLattices, LightSurfacesOfAnySizeWithTrianglesHereAndThere) {
    const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {3, 2}, {7, 65}, {33, 17}, {24, 130}, {90, 70}};
    for (const auto& [width, height] : sizes)
        for (const bool heights : {false, true}) {
            const Codes codes(coding_of(DepthCodingKind::inverse, DepthSemantics::range, true), width, height,
                              heights);
            const FramePair pair{{0, 0, &codes.prev}, {1, 1'000'000, &codes.next}, 0.3};
            const ManyColours colours(width, height);
            compare_light(HeightField(codes.scene, pair), pair, colours.view());
        }
}

TEST(CpuLattices, LeavePlainColoursAsTheyAre) {
    const auto shown = shown_scene("globe", 67, 45);
    const ManyColours colours(67, 45);
    std::vector<float> q;
    CpuLattices lattices(2);
    lattices.q_of(shown->field(), shown->pair(), q);
    std::vector<PackedColour> plain(q.size());
    lattices.light(shown->field(), q.data(), 67, colours.view(), Lighting::plain, plain.data());
    for (std::size_t k = 0; k < plain.size(); ++k)
        ASSERT_EQ(plain[k],
                  pack_colour(colours.bytes[3 * k], colours.bytes[3 * k + 1], colours.bytes[3 * k + 2]));
}

TEST(CpuLattices, AgreeWithTheirTwinForEveryCoding) {
    for (const DepthCodingKind kind : {DepthCodingKind::linear, DepthCodingKind::inverse,
                                       DepthCodingKind::metric, DepthCodingKind::hue, DepthCodingKind::log})
        for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar})
            for (const bool near_is_high : {true, false})
                for (const bool heights : {false, true}) {
                    const Codes codes(coding_of(kind, semantics, near_is_high), 171, 53, heights);
                    for (const double blend : {0.0, 0.25, 0.5, 0.9})
                        compare(codes.scene, codes.prev, codes.next, blend);
                }
}

TEST(CpuLattices, AgreeForPicturesOfAnySize) {
    const DepthCoding coding = coding_of(DepthCodingKind::linear, DepthSemantics::range, true);
    for (const int width : {1, 2, 7, 17, 31, 32, 33, 260})
        for (const int height : {1, 2, 5, 17, 33}) {
            const Codes codes(coding, width, height, false);
            compare(codes.scene, codes.prev, codes.next, 0.6);
        }
}

TEST(CpuLattices, ListTheTilesOfTheirTwinAtTheEdgeOfTheRule) {
    const float edge = 0.01F * CUT_RULE_RATIO;
    const std::vector<float> about_the_edge{0.01F, edge, std::nextafter(edge, 0.0F),
                                            std::nextafter(edge, 1.0F), 0.0F};
    SplitMix64 random(5);
    for (const double holes : {0.0, 0.01, 0.9}) {
        std::vector<float> q(static_cast<std::size_t>(100 * 70));
        for (float& value : q)
            value =
                random.unit() < holes ? 0.0F : about_the_edge[static_cast<std::size_t>(random.within(0, 4))];
        for (const VectorUnit unit : usable_vector_units())
            EXPECT_EQ(CpuLattices(2, unit).tiles_of(100, 70, q), classify_tiles(100, 70, q)) << holes;
    }
}

TEST(CpuLattices, AskTheVerticesWhereThereAreNoCodes) {
    const auto globe = shown_scene("globe", 96, 64);
    SurfaceFrame lazy;
    ASSERT_TRUE(make_lazy_builder(globe->scene)->build(globe->raw_prev, lazy));
    FramePair pair;
    pair.prev = pair.next = {0, 0, &lazy};
    const ViewSurface surface = CpuLattices(1).surface_of(HeightField(globe->scene, pair), pair, {});
    EXPECT_EQ(surface.q, q_of(HeightField(globe->scene, pair)));
    EXPECT_EQ(surface.tiles, classify_tiles(96, 64, surface.q));
}

}  // namespace
}  // namespace touchable::test
