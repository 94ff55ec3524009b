#include "tests/verify/surface.hpp"

#include <gtest/gtest.h>

#include "tests/verify/synthetic.hpp"

namespace touchable::verify {
namespace {

constexpr real tight = 1e-15L;

void expect_near(const Vec3& a, const Vec3& b) {
    EXPECT_LE(length(a - b), tight * (1 + length(b)));
}

/// A square picture of 4 x 4 whose camera makes round numbers: pixel (2 + 3, 2 + 4) has the ray (3, -4, -1).
ExportedFrame round_frame() {
    ExportedFrame frame = blank_frame(4, 4);
    frame.meaning.fx = frame.meaning.fy = 1;
    frame.meaning.cx = frame.meaning.cy = 2;
    frame.meaning.near = 100;
    frame.meaning.far = frame.meaning.scene_far = 200;
    frame.meaning.code_max = 200;
    return frame;
}

TEST(Depth, FollowsTheWrittenCodings) {
    Meaning m;
    m.near = 100;
    m.far = m.scene_far = 200;
    m.code_max = 200;
    EXPECT_EQ(m.depth(0), 200);
    EXPECT_EQ(m.depth(50), 175);
    m.near_is_high = false;
    EXPECT_EQ(m.depth(50), 125);
    m.kind = Meaning::Kind::inverse;
    EXPECT_NEAR(static_cast<double>(m.depth(100)), 1 / 0.0075, 1e-12);
    m.kind = Meaning::Kind::metric;
    m.scale = 0.25L;
    EXPECT_EQ(m.depth(50), 12.5L);
}

TEST(Vertex, RangeLiesAlongTheRayAndPlanarAlongZ) {
    ExportedFrame frame = round_frame();
    frame.codes[0] = 50;  // 175 at the ray (-2, 2, -1), whose length is 3
    expect_near(Surface(frame, frame, 0).vertex(0, 0).position, {-350 / 3.0L, 350 / 3.0L, -175 / 3.0L});
    frame.meaning.range = false;
    expect_near(Surface(frame, frame, 0).vertex(0, 0).position, {-350, 350, -175});
}

TEST(Vertex, HolesAndRingLieFarWithoutHeight) {
    ExportedFrame frame = round_frame();
    frame.meaning.largest_height = 30;
    frame.heights.assign(16, 85);  // a third of it
    frame.codes.assign(16, 100);   // 150
    frame.valid[5] = 0;            // (1, 1)
    frame.meaning.range = false;
    const Surface planar(frame, frame, 0);
    expect_near(planar.vertex(2, 2).position, {0, 0, -140});
    expect_near(planar.vertex(1, 1).position, {-200, 200, -200});
    expect_near(planar.vertex(-1, 2).position, {-600, 0, -200});
    EXPECT_TRUE(planar.vertex(2, 2).solid);
    EXPECT_FALSE(planar.vertex(1, 1).solid);
    EXPECT_FALSE(planar.vertex(4, 4).solid);
    frame.meaning.range = true;
    const Surface range(frame, frame, 0);
    expect_near(range.vertex(4, 4).position, (200 / 3.0L) * Vec3{2, -2, -1});
}

TEST(Surface, OutsideTheRingDepthStaysThatOfTheRing) {
    const ExportedFrame frame = round_frame();
    const Surface surface(frame, frame, 0);
    EXPECT_EQ(surface.q_at({-7, 1.5L}), surface.q_at({-1, 1.5L}));
    EXPECT_EQ(surface.q_at({9, -8}), surface.vertex(4, -1).q);
    for (const ImagePosition at :
         {ImagePosition{-7.3L, 1.4L}, {9.2L, 1.7L}, {1.3L, -3.1L}, {2.6L, 8.5L}, {-2.5L, 7.5L}}) {
        const Facet facet = surface.facet_at(at);  // the plane and the interpolation must tell the same
        EXPECT_LT(dot(facet.normal, facet.point), 0);
        EXPECT_NEAR(
            static_cast<double>(dot(facet.normal, surface.ray(at.x, at.y)) / dot(facet.normal, facet.point)),
            static_cast<double>(surface.q_at(at)), 1e-15);
    }
}

TEST(Surface, IsCutFromUpperLeftToLowerRight) {
    ExportedFrame frame = round_frame();
    frame.meaning.range = false;
    frame.codes[2] = 100;  // (2, 0) is near: cells (1, 0) and (2, 0) rise to it
    const Surface surface(frame, frame, 0);
    const real far_q = 1 / 200.0L, near_q = 1 / 150.0L;
    EXPECT_NEAR(static_cast<double>(surface.q_at({1.75L, 0.25L})),
                static_cast<double>(far_q + 0.5L * (near_q - far_q)), 1e-17);
    EXPECT_NEAR(static_cast<double>(surface.q_at({1.5L, 0.5L})), static_cast<double>(far_q), 1e-17);
    EXPECT_NEAR(static_cast<double>(surface.q_at({1.25L, 0.75L})), static_cast<double>(far_q), 1e-17);
    EXPECT_EQ(surface.facet_at({1.75L, 0.25L}).id.half, 0);
    EXPECT_EQ(surface.facet_at({1.25L, 0.75L}).id.half, 1);
}

TEST(Surface, PlaneAndInterpolationAgreeEverywhere) {
    ExportedFrame frame = blank_frame(9, 7);
    Random random(3);
    for (auto& code : frame.codes) code = static_cast<std::uint16_t>(random.bits());
    const Surface surface(frame, frame, 0);
    for (int k = 0; k < 2000; ++k) {
        const ImagePosition at{random.between(-1, 9), random.between(-1, 7)};
        const Facet facet = surface.facet_at(at);
        const real q = dot(facet.normal, surface.ray(at.x, at.y)) / dot(facet.normal, facet.point);
        EXPECT_NEAR(static_cast<double>(q / surface.q_at(at)), 1, 1e-14);
    }
}

TEST(Surface, BetweenFramesDepthAndHeightAreLinearInTime) {
    ExportedFrame a = round_frame(), b = round_frame();
    a.meaning.range = b.meaning.range = false;
    a.meaning.largest_height = b.meaning.largest_height = 51;
    a.heights.assign(16, 0);
    b.heights.assign(16, 255);
    b.codes.assign(16, 100);
    EXPECT_NEAR(static_cast<double>(Surface(a, b, 0.25L).vertex(2, 2).position.z),
                -(200 - 0.25 * 50 - 0.25 * 51), 1e-12);
    EXPECT_EQ(Surface(a, b, 0).vertex(2, 2).position.z, -200);
}

TEST(Surface, PixelValidInOneFrameTakesTheNearerFramesState) {
    ExportedFrame a = round_frame(), b = round_frame();
    a.meaning.range = b.meaning.range = false;
    b.codes.assign(16, 100);
    b.valid[10] = 0;
    a.valid[0] = 0;
    a.codes.assign(16, 20);
    EXPECT_EQ(Surface(a, b, 0.49L).vertex(2, 2).position.z, -190);
    EXPECT_EQ(Surface(a, b, 0.5L).vertex(2, 2).position.z, -200);
    EXPECT_FALSE(Surface(a, b, 0.5L).vertex(2, 2).solid);
    EXPECT_FALSE(Surface(a, b, 0.49L).vertex(0, 0).solid);
    EXPECT_EQ(Surface(a, b, 0.5L).vertex(0, 0).position.z, -150);
}

TEST(Touch, IsBilinearInSpaceAndLinearInTimeAndSlipsOverHolesAndRing) {
    ExportedFrame a = round_frame(), b = round_frame();
    for (ExportedFrame* frame : {&a, &b}) {
        frame->meaning.low = {1000, 0, 0};
        frame->meaning.high = {3550, 0.51L, 0.255L};
        frame->haptic.assign(48, 0);
    }
    const std::size_t p = 3 * 5;  // pixel (1, 1) of the later frame
    b.haptic[p] = 100;            // 2000 N/m
    b.haptic[p + 1] = b.haptic[p + 2] = 200;
    EXPECT_NEAR(static_cast<double>(Surface(a, b, 0.4L).touch_at({1, 1}).stiffness), 1400, 1e-12);
    const Touch t = Surface(a, b, 0.5L).touch_at({1.25L, 0.5L});  // weight 0.75 x 0.5
    EXPECT_NEAR(static_cast<double>(t.stiffness), 1187.5, 1e-12);
    EXPECT_NEAR(static_cast<double>(t.mu_static), 0.075, 1e-15);
    EXPECT_NEAR(static_cast<double>(t.mu_dynamic), 0.0375, 1e-15);
    b.valid[5] = 0;
    EXPECT_EQ(Surface(a, b, 0.5L).touch_at({1.25L, 0.5L}).mu_static, 0);
    EXPECT_NEAR(static_cast<double>(Surface(a, b, 0.5L).touch_at({1.25L, 0.5L}).stiffness), 1187.5, 1e-12);
    b.haptic.assign(48, 100);
    b.valid[5] = 255;
    const Touch beyond = Surface(a, b, 1).touch_at({-3, 2});
    EXPECT_EQ(beyond.stiffness, 2000);
    EXPECT_EQ(beyond.mu_static, 0);
    EXPECT_NEAR(static_cast<double>(Surface(a, b, 1).touch_at({-0.5L, 2}).mu_static), 0.1, 1e-15);
    for (std::size_t k = 2; k < 48; k += 3) b.haptic[k] = 240;  // mu_d 0.24 where mu_s is 0.2
    EXPECT_NEAR(static_cast<double>(Surface(a, b, 1).touch_at({1.5L, 2}).mu_dynamic), 0.2, 1e-15);
    b.haptic.clear();  // the defaults, without friction
    EXPECT_NEAR(static_cast<double>(Surface(a, b, 0.75L).touch_at({1, 1}).stiffness), 700, 1e-12);
}

TEST(Touch, IsThatOfHolesInCellsThatHaveOneAndFadesOverTheNext) {
    ExportedFrame a = blank_frame(12, 12), b = blank_frame(12, 12);
    for (ExportedFrame* frame : {&a, &b}) frame->meaning.hole_stiffness = 100;
    b.valid[12 * 5 + 5] = 0;
    const auto k = [](const Surface& surface, real x, real y) {
        return static_cast<double>(surface.touch_at({x, y}).stiffness);
    };
    const Surface before(a, b, 0), opening(a, b, 0.25L), open(a, b, 0.5L), closing(b, a, 0.49L),
        closed(b, a, 0.5L);
    for (const auto& [x, y] : {std::pair{5.0L, 5.0L}, {4.0L, 6.0L}, {5.5L, 4.25L}}) {
        EXPECT_NEAR(k(before, x, y), 600, 1e-12);
        EXPECT_NEAR(k(opening, x, y), 350, 1e-12);
        EXPECT_NEAR(k(open, x, y), 100, 1e-12);
        EXPECT_NEAR(k(closing, x, y), 100, 1e-12);
        EXPECT_NEAR(k(closed, x, y), 600, 1e-12);
    }
    EXPECT_NEAR(k(open, 3.5L, 5), 350, 1e-12);
    EXPECT_NEAR(k(open, 6.5L, 6.5L), 475, 1e-12);
    EXPECT_NEAR(k(open, 3, 5), 600, 1e-12);
    EXPECT_NEAR(k(before, -0.5L, 5), 100, 1e-12);  // the ring
    EXPECT_NEAR(k(before, 0.5L, 5), 350, 1e-12);
}

}  // namespace
}  // namespace touchable::verify
