#include "tests/verify/certificate.hpp"

#include <gtest/gtest.h>

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
        code = static_cast<std::uint16_t>(amplitude ? 30000 + random.bits() % amplitude
                                                    : random.bits() % 2 * 65535);
    frame.valid[9 * 32 + 11] = frame.valid[12 * 32 + 20] = 0;
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

TEST(Certificate, HoldsAtEveryClosestPointOfRoughSurfaces) {
    Random random(11);
    int places[3] = {0, 0, 0};
    for (const std::uint64_t amplitude : amplitudes) {
        const ExportedFrame frame = rough_frame(random.bits(), amplitude, amplitude % 3 != 1);
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

TEST(Certificate, FailsBesideEveryClosestPoint) {
    Random random(12);
    for (const std::uint64_t amplitude : amplitudes) {
        const ExportedFrame frame = rough_frame(random.bits(), amplitude, amplitude % 3 != 1);
        const Surface surface(frame, frame, 0);
        for (const Rest& rest : true_minima(surface, 100, random)) {
            const ImagePosition exact = surface.project(rest.proxy);
            const ImagePosition at{exact.x + (random.bits() % 2 ? 1e-4L : -1e-4L),
                                   exact.y + (random.bits() % 2 ? 0.7e-4L : -0.7e-4L)};
            const Vec3 proxy = rounded((1 / surface.q_at(at)) * surface.ray(at.x, at.y));
            const Judgement j = judge(star_at(surface, surface.project(proxy)), proxy, rest.goal, 0);
            EXPECT_FALSE(j.holds()) << "amplitude " << amplitude << " at " << static_cast<double>(at.x) << ' '
                                    << static_cast<double>(at.y);
        }
    }
}

TEST(Certificate, FailsWhereTheWayToTheGoalIsFree) {
    Random random(13);
    const ExportedFrame frame = rough_frame(5, 4000, true);
    const Surface surface(frame, frame, 0);
    for (int k = 0; k < 300; ++k) {  // faces, then edges, then vertices
        const ImagePosition at{k < 200 ? random.between(0, 11) : std::floor(random.between(0, 11)),
                               k < 100 ? random.between(0, 9) : std::floor(random.between(0, 9))};
        const Vec3 proxy = rounded((1 / surface.q_at(at)) * surface.ray(at.x, at.y));
        const Star star = star_at(surface, at);
        EXPECT_EQ(judge(star, proxy, 0.99L * proxy, 0.9L).verdict, Verdict::leaves);
        // along a facet's normal no point of that facet is closer, and still the way is free
        if (star.facets.size() == 1) {
            EXPECT_EQ(judge(star, proxy, proxy + star.facets[0].normal, 0.9L).verdict, Verdict::leaves);
        }
    }
}

TEST(Certificate, OnARidgeTheGoalBeyondTheOtherSideIsSeen) {
    ExportedFrame frame = blank_frame(12, 10);
    make_flat(frame, 40000, 0, 0);
    for (std::size_t k = 0; k < frame.codes.size(); ++k)  // column 6 is nearest
        frame.codes[k] = static_cast<std::uint16_t>(40000 - 3000 * std::abs(static_cast<int>(k % 12) - 6));
    const Surface surface(frame, frame, 0);
    const Vec3 proxy = rounded((1 / surface.q_at({6, 4.3L})) * surface.ray(6, 4.3L));
    const Star star = star_at(surface, {6, 4.3L});
    ASSERT_EQ(star.facets.size(), 2u);
    for (const Facet& side : star.facets)  // closest of that side is the proxy; and the goal is in the open
        EXPECT_EQ(judge(star, proxy, proxy + side.normal, 0).verdict, Verdict::leaves);
    const Vec3 n1 = star.facets[0].normal, n2 = star.facets[1].normal;
    for (const real share : {-0.01L, 0.01L, 0.5L, 0.99L, 1.01L})  // below both sides a ridge never holds
        EXPECT_EQ(judge(star, proxy, proxy - share * n1 - (1 - share) * n2, 0).verdict, Verdict::slides);
}

TEST(Certificate, FindsTheSteepestWayAroundAVertex) {
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
        EXPECT_NEAR(static_cast<double>(j.tangential), static_cast<double>(steepest), 1e-3);
        compared += steepest > 0;
    }
    EXPECT_GT(compared, 30);
}

TEST(Friction, OnAFaceHoldsExactlyWithinTheCone) {
    ExportedFrame frame = blank_frame(12, 10);
    make_flat(frame, 20000, 900, -700);
    const Surface surface(frame, frame, 0);
    for (const ImagePosition at :
         {ImagePosition{4.3L, 5.1L}, {4, 5.1L}, {4, 5}}) {  // flat: places do not matter
        const Vec3 proxy = rounded((1 / surface.q_at(at)) * surface.ray(at.x, at.y));
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

TEST(Friction, OnARidgeHoldsOnlyAlongASidesOwnRim) {
    ExportedFrame frame = blank_frame(12, 10);
    make_flat(frame, 40000, 0, 0);
    for (std::size_t k = 0; k < frame.codes.size(); ++k)
        frame.codes[k] = static_cast<std::uint16_t>(40000 - 3000 * std::abs(static_cast<int>(k % 12) - 6));
    const Surface surface(frame, frame, 0);
    const Vec3 proxy = rounded((1 / surface.q_at({6, 4.3L})) * surface.ray(6, 4.3L));
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

TEST(Friction, InATrenchBothSidesHold) {
    ExportedFrame frame = blank_frame(12, 10);
    make_flat(frame, 20000, 0, 0);
    for (std::size_t k = 0; k < frame.codes.size(); ++k)  // column 6 is deepest
        frame.codes[k] = static_cast<std::uint16_t>(20000 + 3000 * std::abs(static_cast<int>(k % 12) - 6));
    const Surface surface(frame, frame, 0);
    const ImagePosition at{6, 4.3L};
    const Vec3 proxy = rounded((1 / surface.q_at(at)) * surface.ray(at.x, at.y));
    const Star star = star_at(surface, at);
    ASSERT_EQ(star.facets.size(), 2u);
    const Vec3 n1 = star.facets[0].normal, n2 = star.facets[1].normal;
    ASSERT_LT(dot(n1, n2), 0.9L);
    for (const real second : {0.0L, 0.5L, 3.0L}) {
        const Vec3 pressed = proxy - 1 * n1 - second * n2;
        const real held = 0.4L * (1 + second);
        EXPECT_EQ(judge(star, proxy, pressed, 0).verdict, Verdict::minimum);
        for (const real side : {-1.0L, 1.0L}) {
            EXPECT_EQ(judge(star, proxy, pressed + Vec3{0, side * held * 0.9999L, 0}, 0.4L).verdict,
                      Verdict::stuck);
            EXPECT_EQ(judge(star, proxy, pressed + Vec3{0, side * held * 1.0001L, 0}, 0.4L).verdict,
                      Verdict::slides);
        }
    }
}

TEST(Star, CountsTheFacetsOfEveryPlace) {
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

}  // namespace
}  // namespace touchable::verify
