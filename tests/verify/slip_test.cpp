#include <gtest/gtest.h>

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
    /// `inert`: once sliding it leaves the dynamic cone only at rest.
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

TEST_F(Slip, StickAndSlideToTheDynamicConePass) {
    EXPECT_EQ(run(0.3L, 0, false), 0) << out_;
}

TEST_F(Slip, SlidingOnInTheDynamicConePasses) {
    EXPECT_EQ(run(0.3L, 0, true), 0) << out_;
}

TEST_F(Slip, SlidesThatEndElsewhereAreCaught) {
    EXPECT_EQ(run(0.31L, 0, false), 6);
    EXPECT_EQ(run(0.31L, 0, true), 6);
    EXPECT_EQ(run(0.5L, 0, false), 6);
    EXPECT_EQ(run(0, 0, false), 6);  // a minimum, but friction should have held it
    EXPECT_EQ(run(0.31L, 0, false, {"--no-slip"}), 0);
    EXPECT_EQ(run(0.6L, 0, false, {"--no-slip"}), 6);  // outside the static cone
}

TEST_F(Slip, CreepWithinTheConeIsCaught) {
    EXPECT_EQ(run(0.3L, 0.001L, false), 6);
}

}  // namespace
}  // namespace touchable::verify
