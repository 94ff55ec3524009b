// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <stdexcept>

#include "tests/temporary_files.hpp"
#include "tests/verify/certificate.hpp"
#include "tests/verify/exported_frame.hpp"
#include "tests/verify/synthetic.hpp"

namespace touchable::verify {
namespace {

/// Frames no filter ever saw: noise of so many codes over a level; 0: cliffs between the planes.
ExportedFrame rough_frame(std::uint64_t seed, std::uint64_t amplitude, bool range) {
    ExportedFrame frame = blank_frame(32, 24);
    frame.meaning.range = range;
    frame.meaning.fx = frame.meaning.fy = 60;
    Random random(seed);
    for (auto& code : frame.codes)
        code = static_cast<std::uint16_t>(amplitude ? 30000 + random.next() % amplitude
                                                    : random.next() % 2 * 65535);
    frame.valid[9 * 32 + 11] = frame.valid[12 * 32 + 20] = 0;
    return frame;
}

/// A point of the surface, rounded as in a file.
Vec3 point_at(const Surface& surface, ImagePosition at) {
    return rounded((1 / surface.q_at(at)) * surface.ray(at.x, at.y));
}

/// A flat frame but for columns that rise or fall by so many codes each to both sides of column 6.
ExportedFrame folded_frame(int code, int per_column) {
    ExportedFrame frame = blank_frame(12, 10);
    make_flat(frame, code, 0, 0);
    for (std::size_t k = 0; k < frame.codes.size(); ++k)
        frame.codes[k] =
            static_cast<std::uint16_t>(code + per_column * std::abs(static_cast<int>(k % 12) - 6));
    return frame;
}

constexpr std::uint64_t amplitudes[] = {2, 64, 1024, 2048, 4096, 8192, 16384, 0};

struct Rest {
    Vec3 proxy, goal;
};

/// Goals behind the surface with the closest point of the whole surface, which is a minimum whatever the
/// theory.
std::vector<Rest> true_minima(const Surface& surface, int count, Random& random) {
    std::vector<Rest> rests;
    const Meaning& m = surface.meaning();
    while (static_cast<int>(rests.size()) < count) {
        const ImagePosition at{random.between(-1, m.width), random.between(-1, m.height)};
        const real planar = 1 / surface.q_at(at) + random.between(0.001, 20);
        const Vec3 goal = rounded(planar * surface.ray(at.x, at.y));
        const Vec3 proxy = rounded(closest_point(surface, goal));
        const ImagePosition seen = surface.project(proxy);
        const bool inside =
            seen.x > -0.999L && seen.y > -0.999L && seen.x < m.width - 0.001L && seen.y < m.height - 0.001L;
        if (inside) rests.push_back({proxy, goal});  // else what lies outside the ring may be closer still
    }
    return rests;
}

TEST(Certificate, HoldsAtClosestPoints) {
    Random random(11);
    int places[3] = {0, 0, 0};
    for (const std::uint64_t amplitude : amplitudes) {
        const ExportedFrame frame = rough_frame(random.next(), amplitude, amplitude % 3 != 1);
        const Surface surface(frame, frame, 0);
        for (const Rest& rest : true_minima(surface, 150, random)) {
            const Star star = star_at(surface, surface.project(rest.proxy));
            ++places[std::min<std::size_t>(2, star.facets.size() - 1)];
            EXPECT_EQ(judge(star, rest.proxy, rest.goal, 0).verdict, Verdict::minimum)
                << "amplitude " << amplitude << ", " << star.facets.size() << " facets";
        }
    }
    for (int count : places) EXPECT_GT(count, 50);
}

TEST(Certificate, FailsBesideClosestPoints) {
    Random random(12);
    for (const std::uint64_t amplitude : amplitudes) {
        const ExportedFrame frame = rough_frame(random.next(), amplitude, amplitude % 3 != 1);
        const Surface surface(frame, frame, 0);
        for (const Rest& rest : true_minima(surface, 100, random)) {
            const ImagePosition exact = surface.project(rest.proxy);
            const ImagePosition at{exact.x + (random.next() % 2 ? 1e-4L : -1e-4L),
                                   exact.y + (random.next() % 2 ? 0.7e-4L : -0.7e-4L)};
            const Vec3 proxy = point_at(surface, at);
            const Judgement j = judge(star_at(surface, surface.project(proxy)), proxy, rest.goal, 0);
            EXPECT_FALSE(j.holds()) << "amplitude " << amplitude << " at " << static_cast<double>(at.x) << ' '
                                    << static_cast<double>(at.y);
        }
    }
}

TEST(Certificate, FailsOnFreePath) {
    Random random(13);
    const ExportedFrame frame = rough_frame(5, 4000, true);
    const Surface surface(frame, frame, 0);
    for (int k = 0; k < 300; ++k) {  // faces, then edges, then vertices
        const ImagePosition at{k < 200 ? random.between(0, 11) : std::floor(random.between(0, 11)),
                               k < 100 ? random.between(0, 9) : std::floor(random.between(0, 9))};
        const Vec3 proxy = point_at(surface, at);
        const Star star = star_at(surface, at);
        EXPECT_EQ(judge(star, proxy, 0.99L * proxy, 0.9L).verdict, Verdict::leaves);
        // along a facet's normal no point of that facet is closer, and still the way is free
        if (star.facets.size() == 1) {
            EXPECT_EQ(judge(star, proxy, proxy + star.facets[0].normal, 0.9L).verdict, Verdict::leaves);
        }
    }
}

TEST(Certificate, SeesGoalBeyondRidge) {
    const ExportedFrame frame = folded_frame(40000, -3000);
    const Surface surface(frame, frame, 0);
    const Vec3 proxy = point_at(surface, {6, 4.3L});
    const Star star = star_at(surface, {6, 4.3L});
    ASSERT_EQ(star.facets.size(), 2u);
    for (const Facet& side : star.facets)  // closest of that side is the proxy; and the goal is in the open
        EXPECT_EQ(judge(star, proxy, proxy + side.normal, 0).verdict, Verdict::leaves);
    const Vec3 n1 = star.facets[0].normal, n2 = star.facets[1].normal;
    for (const real share : {-0.01L, 0.01L, 0.5L, 0.99L, 1.01L})  // below both sides a ridge never holds
        EXPECT_EQ(judge(star, proxy, proxy - share * n1 - (1 - share) * n2, 0).verdict, Verdict::slides);
}

TEST(Certificate, FindsSteepestDirectionAtVertex) {
    const ExportedFrame frame = rough_frame(9, 4000, true);
    const Surface surface(frame, frame, 0);
    Random random(14);
    int compared = 0;
    for (int k = 0; k < 100; ++k) {
        const ImagePosition at{std::floor(random.between(-1, 32)), std::floor(random.between(-1, 24))};
        const Vec3 proxy = surface.vertex(static_cast<int>(at.x), static_cast<int>(at.y)).position;
        const Vec3 goal = proxy + Vec3{random.between(-2, 2), random.between(-2, 2), random.between(-2, 0)};
        const Judgement j = judge(star_at(surface, at), proxy, goal, 0);
        if (j.verdict == Verdict::leaves) continue;
        real steepest = 0;  // by walking a little way in each of many directions
        for (int turn = 0; turn < 3000; ++turn) {
            const real angle = 0.00209439510239319549L * turn;
            const ImagePosition near{at.x + 1e-4L * std::cos(angle), at.y + 1e-4L * std::sin(angle)};
            const Vec3 step = (1 / surface.q_at(near)) * surface.ray(near.x, near.y) - proxy;
            steepest = std::max(steepest, dot(unit(step), goal - proxy));
        }
        EXPECT_NEAR(narrow(j.tangential), static_cast<double>(steepest), 1e-3);
        compared += steepest > 0;
    }
    EXPECT_GT(compared, 30);
}

TEST(FrictionCertificate, HoldsWithinConeOnFace) {
    ExportedFrame frame = blank_frame(12, 10);
    make_flat(frame, 20000, 900, -700);
    const Surface surface(frame, frame, 0);
    for (const ImagePosition at :
         {ImagePosition{4.3L, 5.1L}, {4, 5.1L}, {4, 5}}) {  // flat: places do not matter
        const Vec3 proxy = point_at(surface, at);
        const Star star = star_at(surface, at);
        const Vec3 n = star.facets[0].normal;
        for (int turn = 0; turn < 12; ++turn) {
            const Vec3 a = unit(cross(n, {0, 1, 0})), b = cross(n, a);
            const Vec3 t = std::cos(0.5L * turn) * a + std::sin(0.5L * turn) * b;
            EXPECT_EQ(judge(star, proxy, proxy - 2 * n + 0.7999L * t, 0.4L).verdict, Verdict::stuck);
            EXPECT_EQ(judge(star, proxy, proxy - 2 * n + 0.8001L * t, 0.4L).verdict, Verdict::slides);
        }
    }
}

TEST(FrictionCertificate, RidgeHoldsAlongItsRim) {
    const ExportedFrame frame = folded_frame(40000, -3000);
    const Surface surface(frame, frame, 0);
    const Vec3 proxy = point_at(surface, {6, 4.3L});
    const Star star = star_at(surface, {6, 4.3L});
    ASSERT_EQ(star.facets.size(), 2u);
    const Vec3 along = star.edges[0];
    for (std::size_t k = 0; k < 2; ++k) {
        const Vec3 n = star.facets[k].normal;
        Vec3 across = unit(cross(along, n));  // in the facet's plane, over the rim to the other side
        if (dot(across, star.facets[1 - k].normal) < 0) across = -1 * across;
        EXPECT_EQ(judge(star, proxy, proxy - n + 0.39L * along, 0.4L).verdict, Verdict::stuck);
        EXPECT_EQ(judge(star, proxy, proxy - n + 0.41L * along, 0.4L).verdict, Verdict::slides);
        EXPECT_EQ(judge(star, proxy, proxy - n - 0.1L * across, 0.4L).verdict, Verdict::stuck);
        EXPECT_EQ(judge(star, proxy, proxy - n + 0.1L * across, 0.4L).verdict, Verdict::slides);
    }
}

TEST(FrictionCertificate, TrenchHoldsOnBothSides) {
    const ExportedFrame frame = folded_frame(20000, 3000);
    const Surface surface(frame, frame, 0);
    const ImagePosition at{6, 4.3L};
    const Vec3 proxy = point_at(surface, at);
    const Star star = star_at(surface, at);
    ASSERT_EQ(star.facets.size(), 2u);
    const Vec3 n1 = star.facets[0].normal, n2 = star.facets[1].normal;
    ASSERT_LT(dot(n1, n2), 0.9L);
    for (const real second : {0.0L, 0.5L, 3.0L}) {
        const Vec3 pressed = proxy - 1 * n1 - second * n2;
        const real held = 0.4L * (1 + second);
        EXPECT_EQ(judge(star, proxy, pressed, 0).verdict, Verdict::minimum);
        for (const real side : {-held, held}) {
            const Vec3 inside{0, side * 0.9999L, 0}, outside{0, side * 1.0001L, 0};
            EXPECT_EQ(judge(star, proxy, pressed + inside, 0.4L).verdict, Verdict::stuck);
            EXPECT_EQ(judge(star, proxy, pressed + outside, 0.4L).verdict, Verdict::slides);
        }
    }
}

TEST(Star, CountsFacetsOfEveryPlace) {
    const ExportedFrame frame = rough_frame(7, 4000, true);
    const Surface surface(frame, frame, 0);
    const auto count = [&](real x, real y) { return star_at(surface, {x, y}).facets.size(); };
    EXPECT_EQ(count(3.4L, 3.3L), 1u);
    EXPECT_EQ(count(3.4L, 3.4L), 2u);
    EXPECT_EQ(count(3, 3.4L), 2u);
    EXPECT_EQ(count(3.4L, 3), 2u);
    EXPECT_EQ(count(3, 3), 6u);
    EXPECT_EQ(count(3 + 1e-12L, 3 - 1e-12L), 6u);
    EXPECT_EQ(count(3 + 1e-8L, 3 - 1e-9L), 1u);
    EXPECT_EQ(count(-1, 4), 5u);   // three triangles of the ring and two strips
    EXPECT_EQ(count(-1, -1), 5u);  // two triangles, two strips, the corner
    EXPECT_EQ(count(32, -1), 4u);  // one triangle, two strips, the corner
    EXPECT_EQ(count(-3, 4), 2u);   // two strips
    EXPECT_EQ(count(-3, 4.5L), 1u);
    EXPECT_EQ(count(-3, -4), 1u);
    EXPECT_EQ(count(34, -1), 2u);  // a strip and the corner
}

/// Coulomb friction on one plane, from the textbook: the reference of the slip check.
class SlipCheck : public testing::Test {
protected:
    void SetUp() override {
        make_flat(frame_, 20000, 900, -700);
        frame_.meaning.by_default = {600, 0.5L, 0.3L};
        write_frame(folder_.path() / "0", frame_);
    }

    /// `stop`: cone in which a slide ends; `creep`: movement towards the closest point although it sticks;
    /// `inert`: once sliding it sticks only after a tick at rest, as it should.
    int run(real stop, real creep, bool inert, const std::vector<std::string>& more = {}) {
        begin({5.62L, 5.31L});  // within one facet all the time
        bool sliding = false;
        for (int tick = 0; tick < 40; ++tick) {
            const real pressure = 0.8L;
            const Vec3 closest = first_ + 0.02L * tick * across_, away = proxy_ - closest;
            const bool sticks = length(away) <= (sliding ? stop : 0.5L) * pressure;
            sliding = inert && !sticks;
            proxy_ = sticks ? proxy_ - creep * away : closest + (stop * pressure / length(away)) * away;
            press(tick, closest, pressure);
        }
        return code(more);
    }

    void begin(ImagePosition start) {
        surface_.emplace(frame_, frame_, 0);
        facet_ = surface_->facet_at(start);
        proxy_ = first_ = (1 / surface_->q_at(start)) * surface_->ray(start.x, start.y);
        across_ = unit(cross(facet_.normal, {0, 1, 0}));
        rows_.clear();
    }
    void press(int tick, const Vec3& closest, real pressure) {
        rows_.push_back(contact_row(*surface_, proxy_, closest - pressure * facet_.normal));
        rows_.back().tick = tick;
    }
    int code(const std::vector<std::string>& more = {}) {
        const Outcome outcome = verify(folder_.path(), rows_, more);
        out_ = outcome.out;
        return outcome.code;
    }

    test::TemporaryFolder folder_;
    ExportedFrame frame_ = blank_frame(12, 10);
    std::optional<Surface> surface_;
    Facet facet_;
    Vec3 proxy_, first_, across_;
    std::vector<Row> rows_;
    std::string out_;
};

TEST_F(SlipCheck, CatchesEarlySticking) {
    EXPECT_EQ(run(0.3L, 0, false), 6);
    EXPECT_EQ(run(0.3L, 0, false, {"--no-slip"}), 0) << out_;
}

TEST_F(SlipCheck, PassesSlidingInCone) {
    EXPECT_EQ(run(0.3L, 0, true), 0) << out_;
}

TEST_F(SlipCheck, CatchesSlidesEndingElsewhere) {
    EXPECT_EQ(run(0.31L, 0, true), 6);
    EXPECT_EQ(run(0.5L, 0, true), 6);
    EXPECT_EQ(run(0, 0, true), 6);  // a minimum, but friction should have held it
    EXPECT_EQ(run(0.31L, 0, false, {"--no-slip"}), 0);
    EXPECT_EQ(run(0.6L, 0, false, {"--no-slip"}), 6);  // outside the static cone
}

TEST_F(SlipCheck, CatchesCreep) {
    EXPECT_EQ(run(0.3L, 0.001L, true), 6);
}

/// A finger dragged over friction painted at random; `at_end`: a slide ends by mu of its end, else of its
/// start.
class UnevenSlipCheck : public SlipCheck {
protected:
    int drag(bool at_end, std::uint64_t seed) {
        Random random(seed);
        frame_.meaning.low = {600, 0, 0};
        frame_.meaning.high = {600, 1, 0.7L};
        for (std::size_t k = 0; k < 3 * frame_.codes.size(); ++k)
            frame_.haptic.push_back(static_cast<std::uint8_t>(random.next()));
        write_frame(folder_.path() / "0", frame_);
        begin({5.6L, 5.3L});
        const auto mu_at = [&](const Vec3& p) { return surface_->touch_at(surface_->project(p)); };
        bool sliding = false;
        for (int tick = 0; tick < 80; ++tick) {
            const real pressure = 0.6L + 0.2L * std::sin(0.3L * tick);
            const Vec3 closest = first_ + std::sin(0.1L * tick) * across_, way = closest - proxy_;
            const auto held = [&](real share, real mu) { return (1 - share) * length(way) <= mu * pressure; };
            const Touch here = mu_at(proxy_);
            const bool stays = held(0, sliding ? here.mu_dynamic : here.mu_static);
            if (!stays) {
                real low = 0, high = 0;
                const auto mu_after = [&](real share) {
                    return at_end ? mu_at(proxy_ + share * way).mu_dynamic : here.mu_dynamic;
                };
                while (!held(high, mu_after(high))) {
                    low = high;
                    high += 1e-3L;
                }
                for (int k = 0; k < 70; ++k) {
                    const real middle = (low + high) / 2;
                    (held(middle, mu_after(middle)) ? high : low) = middle;
                }
                proxy_ = proxy_ + high * way;
            }
            sliding = !stays;
            press(tick, closest, pressure);
            if (!(surface_->facet_at(surface_->project(proxy_)) == facet_))
                throw std::logic_error("left the facet");
        }
        return code();
    }
};

TEST_F(UnevenSlipCheck, PassesFrictionOfEnd) {
    EXPECT_EQ(drag(true, 5), 0) << out_;
    EXPECT_EQ(out_.find("whose step within a facet was checked              0"), std::string::npos);
}

TEST_F(UnevenSlipCheck, CatchesFrictionOfStart) {
    EXPECT_EQ(drag(false, 5), 6);
}

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
    Meaning m = round_frame().meaning;
    EXPECT_EQ(m.depth(0), 200);
    EXPECT_EQ(m.depth(50), 175);
    m.near_is_high = false;
    EXPECT_EQ(m.depth(50), 125);
    m.kind = Meaning::Kind::inverse;
    EXPECT_NEAR(narrow(m.depth(100)), 1 / 0.0075, 1e-12);
    m.kind = Meaning::Kind::metric;
    m.scale = 0.25L;
    EXPECT_EQ(m.depth(50), 12.5L);
}

TEST(Vertex, FollowsDepthSemantics) {
    ExportedFrame frame = round_frame();
    frame.codes[0] = 50;  // 175 at the ray (-2, 2, -1), whose length is 3
    expect_near(Surface(frame, frame, 0).vertex(0, 0).position, {-350 / 3.0L, 350 / 3.0L, -175 / 3.0L});
    frame.meaning.range = false;
    expect_near(Surface(frame, frame, 0).vertex(0, 0).position, {-350, 350, -175});
}

TEST(Vertex, HolesAndRingLieFar) {
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

TEST(Surface, DepthStaysBeyondRing) {
    const ExportedFrame frame = round_frame();
    const Surface surface(frame, frame, 0);
    EXPECT_EQ(surface.q_at({-7, 1.5L}), surface.q_at({-1, 1.5L}));
    EXPECT_EQ(surface.q_at({9, -8}), surface.vertex(4, -1).q);
    for (const ImagePosition at :
         {ImagePosition{-7.3L, 1.4L}, {9.2L, 1.7L}, {1.3L, -3.1L}, {2.6L, 8.5L}, {-2.5L, 7.5L}}) {
        const Facet facet = surface.facet_at(at);  // the plane and the interpolation must tell the same
        EXPECT_LT(dot(facet.normal, facet.point), 0);
        EXPECT_NEAR(narrow(dot(facet.normal, surface.ray(at.x, at.y)) / dot(facet.normal, facet.point)),
                    static_cast<double>(surface.q_at(at)), 1e-15);
    }
}

TEST(Surface, CellsSplitAlongDiagonal) {
    ExportedFrame frame = round_frame();
    frame.meaning.range = false;
    frame.codes[2] = 100;  // (2, 0) is near: cells (1, 0) and (2, 0) rise to it
    const Surface surface(frame, frame, 0);
    const real far_q = 1 / 200.0L, near_q = 1 / 150.0L;
    EXPECT_NEAR(narrow(surface.q_at({1.75L, 0.25L})), static_cast<double>(far_q + 0.5L * (near_q - far_q)),
                1e-17);
    EXPECT_NEAR(narrow(surface.q_at({1.5L, 0.5L})), static_cast<double>(far_q), 1e-17);
    EXPECT_NEAR(narrow(surface.q_at({1.25L, 0.75L})), static_cast<double>(far_q), 1e-17);
    EXPECT_EQ(surface.facet_at({1.75L, 0.25L}).id.half, 0);
    EXPECT_EQ(surface.facet_at({1.25L, 0.75L}).id.half, 1);
}

TEST(Surface, PlaneAndInterpolationAgreeEverywhere) {
    ExportedFrame frame = blank_frame(9, 7);
    Random random(3);
    for (auto& code : frame.codes) code = static_cast<std::uint16_t>(random.next());
    const Surface surface(frame, frame, 0);
    for (int k = 0; k < 2000; ++k) {
        const ImagePosition at{random.between(-1, 9), random.between(-1, 7)};
        const Facet facet = surface.facet_at(at);
        const real q = dot(facet.normal, surface.ray(at.x, at.y)) / dot(facet.normal, facet.point);
        EXPECT_NEAR(narrow(q / surface.q_at(at)), 1, 1e-14);
    }
}

TEST(Surface, InterpolatesDepthAndHeight) {
    ExportedFrame a = round_frame(), b = round_frame();
    a.meaning.range = b.meaning.range = false;
    a.meaning.largest_height = b.meaning.largest_height = 51;
    a.heights.assign(16, 0);
    b.heights.assign(16, 255);
    b.codes.assign(16, 100);
    EXPECT_NEAR(narrow(Surface(a, b, 0.25L).vertex(2, 2).position.z), -(200 - 0.25 * 50 - 0.25 * 51), 1e-12);
    EXPECT_EQ(Surface(a, b, 0).vertex(2, 2).position.z, -200);
}

TEST(Surface, NearerFrameDecidesValidity) {
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

TEST(Touch, InterpolatesAndSlipsOverHoles) {
    ExportedFrame a = round_frame(), b = round_frame();
    for (ExportedFrame* frame : {&a, &b}) {
        frame->meaning.low = {1000, 0, 0};
        frame->meaning.high = {3550, 0.51L, 0.255L};
        frame->haptic.assign(48, 0);
    }
    const std::size_t p = 3 * 5;  // pixel (1, 1) of the later frame
    b.haptic[p] = 100;            // 2000 N/m
    b.haptic[p + 1] = b.haptic[p + 2] = 200;
    EXPECT_NEAR(narrow(Surface(a, b, 0.4L).touch_at({1, 1}).stiffness), 1400, 1e-12);
    const Touch t = Surface(a, b, 0.5L).touch_at({1.25L, 0.5L});  // weight 0.75 x 0.5
    EXPECT_NEAR(narrow(t.stiffness), 1187.5, 1e-12);
    EXPECT_NEAR(narrow(t.mu_static), 0.075, 1e-15);
    EXPECT_NEAR(narrow(t.mu_dynamic), 0.0375, 1e-15);
    b.valid[5] = 0;
    EXPECT_EQ(Surface(a, b, 0.5L).touch_at({1.25L, 0.5L}).mu_static, 0);
    EXPECT_NEAR(narrow(Surface(a, b, 0.5L).touch_at({1.25L, 0.5L}).stiffness), 1187.5, 1e-12);
    b.haptic.assign(48, 100);
    b.valid[5] = 255;
    const Touch beyond = Surface(a, b, 1).touch_at({-3, 2});
    EXPECT_EQ(beyond.stiffness, 2000);
    EXPECT_EQ(beyond.mu_static, 0);
    EXPECT_NEAR(narrow(Surface(a, b, 1).touch_at({-0.5L, 2}).mu_static), 0.1, 1e-15);
    for (std::size_t k = 2; k < 48; k += 3) b.haptic[k] = 240;  // mu_d 0.24 where mu_s is 0.2
    EXPECT_NEAR(narrow(Surface(a, b, 1).touch_at({1.5L, 2}).mu_dynamic), 0.2, 1e-15);
    b.haptic.clear();  // the defaults, without friction
    EXPECT_NEAR(narrow(Surface(a, b, 0.75L).touch_at({1, 1}).stiffness), 700, 1e-12);
}

TEST(Touch, HoleStiffnessFadesOverCells) {
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
