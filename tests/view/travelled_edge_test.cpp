// Between two frames of a thing that moves, nothing is drawn in the air where its edge has travelled.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "player/draw/cpu_painting.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/overlay_rows.hpp"
#include "player/draw/view.hpp"
#include "tests/gpu/gpu_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int width = 96, height = 40;
using Millimetres = std::function<int(int x)>;

/// Two frames of metric codes of a millimetre, 1/30 s apart, each the same in all rows.
struct TwoFrames {
    TwoFrames(const Millimetres& before, const Millimetres& after) {
        scene.width = width;
        scene.height = height;
        scene.metres_per_unit = 1;
        scene.camera = {90, 90, 0.5 * (width - 1), 0.5 * (height - 1)};
        scene.depth.kind = DepthCodingKind::metric;
        scene.depth.semantics = DepthSemantics::planar;
        scene.depth.scale = 0.001;
        scene.depth.far = 60;
        scene.depth.code_max = 65535;
        derive_valid_range(scene.depth);
        make(prev, before);
        make(next, after);
    }
    void make(SurfaceFrame& frame, const Millimetres& millimetres) {
        frame.width = width;
        frame.height = height;
        frame.coding = scene.depth;
        for (int k = 0; k < width * height; ++k)
            frame.codes.push_back(static_cast<std::uint16_t>(millimetres(k % width)));
        frame.validity.assign(
            static_cast<std::size_t>(frame.validity_words_per_row()) * static_cast<std::size_t>(height), ~0U);
        const TileGrid tiles = TileGrid::of(width, height);
        const auto [least, greatest] = std::minmax_element(frame.codes.begin(), frame.codes.end());
        for (int k = 0; k < tiles.tiles_x * tiles.tiles_y; ++k) frame.tiles.push_back({*least, *greatest});
        frame.vertices = std::make_unique<FilteredVertices>(frame);
    }
    FramePair pair(double blend) const { return {{0, 0, &prev}, {1, 33'333'333, &next}, blend}; }

    Scene scene;
    SurfaceFrame prev, next;
};

/// Planar depths of what is drawn, m, by everyone who draws or reads it.
class TravelledEdge : public GpuTest {
protected:
    std::vector<std::vector<double>> drawn(const TwoFrames& frames, double blend) {
        const FramePair pair = frames.pair(blend);
        const HeightField field(frames.scene, pair);
        std::vector<std::vector<double>> all;
        const auto of_q = [&](const std::vector<float>& q) {
            auto& depths = all.emplace_back();
            for (const float each : q) depths.push_back(1 / static_cast<double>(each));
        };
        of_q(q_of(field));
        of_q(CpuLattices(1).surface_of(field, pair, {}).q);
        of_q(must(GpuLattices(gpu).surface_of(field, pair, {})).q);
        std::vector<double> values, rows;
        ScalarRows reads;
        reads.begin(Scalar::depth, field, pair);
        std::vector<float> row(width);
        for (int y = 0; y < height; ++y) {
            reads.read(y, row.data());
            rows.insert(rows.end(), row.begin(), row.end());
            for (int x = 0; x < width; ++x) values.push_back(values_at(field, pair, x, y).depth);
        }
        all.push_back(values);
        all.push_back(rows);
        return all;
    }
};

/// A box of 30 columns at 1 m before a wall at 2 m.
Millimetres box_from(int left) {
    return [left](int x) { return x >= left && x < left + 30 ? 1000 : 2000; };
}

TEST_F(TravelledEdge, OfABoxLeavesNothingBetweenTheBoxAndTheWall) {
    const TwoFrames frames(box_from(30), box_from(37));
    for (const double blend : {0.25, 0.5, 0.75}) {
        const auto all = drawn(frames, blend);
        const int left = blend < 0.5 ? 30 : 37;
        for (std::size_t who = 0; who < all.size(); ++who)
            for (int k = 0; k < width * height; ++k)
                ASSERT_NEAR(all[who][static_cast<std::size_t>(k)], 0.001 * box_from(left)(k % width), 1e-5)
                    << "column " << k % width << ", reader " << who << ", blend " << blend;
    }
}

TEST_F(TravelledEdge, IsFeltAsARampForAFrame) {
    const TwoFrames frames(box_from(30), box_from(37));
    const FramePair pair = frames.pair(0.5);
    EXPECT_DOUBLE_EQ(HeightField(frames.scene, pair).vertex(33, 20).depth, 1.5);
}

TEST_F(TravelledEdge, IsPickedAsItIsDrawn) {
    const TwoFrames frames(box_from(30), box_from(37));
    const FramePair pair = frames.pair(0.5);
    const HeightField field(frames.scene, pair);
    const ViewCamera aside =
        make_view(*parse_viewpoint("orbit:az=40,el=0"), frames.scene, {0, 0, -1.5}, 160, 100);
    int boxes = 0, walls = 0;
    for (int x = 0; x < 160; ++x) {
        const auto met = pick(field, aside, x + 0.5, 50);
        if (!met || !met->drawn) continue;
        (met->depth < 1.5 ? boxes : walls) += 1;
        ASSERT_NEAR(met->depth, met->depth < 1.5 ? 1 : 2, 1e-6) << x;
        // From aside edges are half a pixel outside the last vertex.
        ASSERT_EQ(met->depth < 1.5, met->x >= 36.5 && met->x <= 66.5) << x;
    }
    EXPECT_GT(boxes, 10);
    EXPECT_GT(walls, 10);
}

TEST_F(TravelledEdge, IsNoneWhereAPlaneComesAsFastAsAHand) {
    for (const int distance : {400, 1000, 5000}) {  // 66 mm in 1/30 s are 2 m/s
        const TwoFrames frames([=](int) { return distance; }, [=](int) { return distance - 66; });
        for (const auto& depths : drawn(frames, 0.25))
            for (const double depth : depths) ASSERT_NEAR(depth, 0.001 * distance - 0.0165, 1e-5) << distance;
    }
}

TEST_F(TravelledEdge, MixesBySpeedDistanceAndBothTheirLimits) {
    struct Case {
        int before, after;
        bool is_mixed;
    };
    const Case cases[] = {{1000, 1066, true}, {1000, 1068, false},                      // 2 m/s
                          {2000, 2124, true}, {2000, 2126, false},                      // a sixteenth
                          {100, 124, true},   {100, 126, false},   {126, 100, false}};  // a quarter
    for (const Case& each : cases) {
        const TwoFrames frames([&](int) { return each.before; }, [&](int) { return each.after; });
        const double wanted = 0.001 * (each.is_mixed ? 0.75 * each.before + 0.25 * each.after : each.before);
        for (const auto& depths : drawn(frames, 0.25))
            ASSERT_NEAR(depths[0], wanted, 1e-5) << each.before << " to " << each.after;
    }
}

TEST_F(TravelledEdge, OfASlowClipIsNoMovement) {
    const TwoFrames frames(box_from(30), box_from(37));
    FramePair pair = frames.pair(0.5);
    pair.next.time_ns = 2'000'000'000;
    EXPECT_EQ(drawn_vertex(HeightField(frames.scene, pair), 33, 20).depth, 2);
    EXPECT_NEAR(blend_reach(HeightField(frames.scene, pair)), 2 / 24., 1e-6);
}

}  // namespace
}  // namespace touchable::test
