// Ticks as multiples of square roots, whatever the machine's clock.

#include "bench/tick_times.hpp"

#include <gtest/gtest.h>

#include "bench/clocks.hpp"

namespace touchable {
namespace {

/// Ticks of 2000 dependent square roots each; one in fifty has four times as many.
class Roots final : public TimedRun {
public:
    int ticks() const override { return 1000; }
    void restart() override {}
    void tick(int k) override {
        for (int n = 0; n < (k % 50 == 0 ? 8 : 2); ++n) root_ns();  // times 1000
    }
};

TEST(TickTimes, CountSquareRoots) {
    Roots run;
    const TickTimes times = time_hot(run, 7);
    EXPECT_NEAR(times.roots, 0.98 * 2000 + 0.02 * 8000, 300);
    EXPECT_NEAR(times.roots_p99, 8000, 1200);
    EXPECT_EQ(times.wall_us.size(), 7000U);
}

}  // namespace
}  // namespace touchable
