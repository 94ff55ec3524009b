#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/temporary_folder.hpp"
#include "tests/verify/synthetic.hpp"

namespace touchable::verify {
namespace {

/// Coulomb friction on one plane, from the textbook: the reference of the slip check.
class Slip : public testing::Test {
protected:
    void SetUp() override {
        make_flat(frame_, 20000, 900, -700);
        frame_.meaning.by_default = {600, 0.5L, 0.3L};
        write_frame(folder_.path() / "0", frame_);
    }

    /// `stop`: cone in which a slide ends; `creep`: movement towards the closest point although it sticks;
    /// `inert`: once sliding it sticks only after a tick at rest, as it should.
    int run(real stop, real creep, bool inert, const std::vector<std::string>& more = {}) {
        const Surface surface(frame_, frame_, 0);
        const ImagePosition start{5.62L, 5.31L};  // within one facet all the time
        const Facet facet = surface.facet_at(start);
        Vec3 proxy = (1 / surface.q_at(start)) * surface.ray(start.x, start.y);
        const Vec3 first = proxy, across = unit(cross(facet.normal, {0, 1, 0}));
        std::vector<Row> rows;
        bool sliding = false;
        for (int tick = 0; tick < 40; ++tick) {
            const real pressure = 0.8L;
            const Vec3 closest = first + 0.02L * tick * across, away = proxy - closest;
            const bool sticks = length(away) <= (sliding ? stop : 0.5L) * pressure;
            sliding = inert && !sticks;
            if (sticks)
                proxy = proxy - creep * away;
            else
                proxy = closest + (stop * pressure / length(away)) * away;
            rows.push_back(contact_row(surface, proxy, closest - pressure * facet.normal));
            rows.back().tick = tick;
        }
        const Outcome outcome = verify(folder_.path(), rows, more);
        out_ = outcome.out;
        return outcome.code;
    }

    test::TemporaryFolder folder_;
    ExportedFrame frame_ = blank_frame(12, 10);
    std::string out_;
};

TEST_F(Slip, AProxyThatHasSlidAndSticksBeforeItHasRestedIsCaught) {
    EXPECT_EQ(run(0.3L, 0, false), 6);
    EXPECT_EQ(run(0.3L, 0, false, {"--no-slip"}), 0) << out_;
}

TEST_F(Slip, SlidingOnInTheDynamicConePasses) {
    EXPECT_EQ(run(0.3L, 0, true), 0) << out_;
}

TEST_F(Slip, SlidesThatEndElsewhereAreCaught) {
    EXPECT_EQ(run(0.31L, 0, true), 6);
    EXPECT_EQ(run(0.5L, 0, true), 6);
    EXPECT_EQ(run(0, 0, true), 6);  // a minimum, but friction should have held it
    EXPECT_EQ(run(0.31L, 0, false, {"--no-slip"}), 0);
    EXPECT_EQ(run(0.6L, 0, false, {"--no-slip"}), 6);  // outside the static cone
}

TEST_F(Slip, CreepWithinTheConeIsCaught) {
    EXPECT_EQ(run(0.3L, 0.001L, true), 6);
}

/// A finger dragged over friction painted at random; `at_end`: a slide ends by mu of its end, else of its
/// start.
class UnevenSlip : public Slip {
protected:
    int drag(bool at_end, std::uint64_t seed) {
        Random random(seed);
        frame_.meaning.low = {600, 0, 0};
        frame_.meaning.high = {600, 1, 0.7L};
        for (std::size_t k = 0; k < 3 * frame_.codes.size(); ++k)
            frame_.haptic.push_back(static_cast<std::uint8_t>(random.bits()));
        write_frame(folder_.path() / "0", frame_);
        const Surface surface(frame_, frame_, 0);
        const ImagePosition start{5.6L, 5.3L};
        const Facet facet = surface.facet_at(start);
        Vec3 proxy = (1 / surface.q_at(start)) * surface.ray(start.x, start.y);
        const Vec3 first = proxy, across = unit(cross(facet.normal, {0, 1, 0}));
        const auto mu_at = [&](const Vec3& p) { return surface.touch_at(surface.project(p)); };
        std::vector<Row> rows;
        bool sliding = false;
        for (int tick = 0; tick < 80; ++tick) {
            const real pressure = 0.6L + 0.2L * std::sin(0.3L * tick);
            const Vec3 closest = first + std::sin(0.1L * tick) * across, way = closest - proxy;
            const auto held = [&](real share, real mu) { return (1 - share) * length(way) <= mu * pressure; };
            const Touch here = mu_at(proxy);
            const bool stays = held(0, sliding ? here.mu_dynamic : here.mu_static);
            if (!stays) {
                real low = 0, high = 0;
                const auto mu_after = [&](real share) {
                    return at_end ? mu_at(proxy + share * way).mu_dynamic : here.mu_dynamic;
                };
                while (!held(high, mu_after(high))) {
                    low = high;
                    high += 1e-3L;
                }
                for (int k = 0; k < 70; ++k) {
                    const real middle = (low + high) / 2;
                    (held(middle, mu_after(middle)) ? high : low) = middle;
                }
                proxy = proxy + high * way;
            }
            sliding = !stays;
            rows.push_back(contact_row(surface, proxy, closest - pressure * facet.normal));
            rows.back().tick = tick;
            if (!(surface.facet_at(surface.project(proxy)) == facet))
                throw std::logic_error("left the facet");
        }
        const Outcome outcome = verify(folder_.path(), rows, {});
        out_ = outcome.out;
        return outcome.code;
    }
};

TEST_F(UnevenSlip, EndsByTheFrictionOfWhereItEnds) {
    EXPECT_EQ(drag(true, 5), 0) << out_;
    EXPECT_EQ(out_.find("whose step within a facet was checked              0"), std::string::npos);
}

TEST_F(UnevenSlip, ThatEndsByTheFrictionOfItsStartIsCaught) {
    EXPECT_EQ(drag(false, 5), 6);
}

}  // namespace
}  // namespace touchable::verify
