// Two solvers in two threads, and frames that are pushed while a solver ticks.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/capi/hill.hpp"

namespace touchable::test {
namespace {

std::uint64_t hash_of_a_run() {
    TouchedHill touched;
    for (std::int64_t tick = 0; tick < 500; ++tick) {
        const touch_tick at = tick_at(tick);
        const touch_vec3 goal = goal_at(tick);
        touch_contact contact;
        EXPECT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
    }
    std::uint64_t hash = 0;
    EXPECT_EQ(touch_solver_force_hash(touched.solver, &hash), TOUCH_OK);
    return hash;
}

TEST(Threads, TwoSolversInTwoThreads) {
    const std::uint64_t expected = hash_of_a_run();
    std::uint64_t one = 0, other = 0;
    std::thread first([&] { one = hash_of_a_run(); }), second([&] { other = hash_of_a_run(); });
    first.join();
    second.join();
    EXPECT_EQ(one, expected);
    EXPECT_EQ(other, expected);
}

TEST(Threads, OnePushesWhileAnotherTicks) {
    TouchedHill touched;
    constexpr std::int64_t frames = 60;
    std::atomic<bool> pushed_all{false};
    std::thread writer([&] {
        for (std::int64_t n = 1; n < frames; ++n) {
            const Hill hill(static_cast<int>(n % 5));
            const touch_frame frame = hill.frame(n);
            touch_status status = TOUCH_FULL;
            while ((status = touch_surface_push(touched.surface, &frame, nullptr)) == TOUCH_FULL)
                std::this_thread::yield();
            EXPECT_EQ(status, TOUCH_OK);
        }
        pushed_all = true;
    });
    touch_contact contact;
    std::int64_t newest = 0;
    for (std::int64_t tick = 0; !pushed_all; ++tick) {
        touch_tick at = tick_at(tick);
        EXPECT_EQ(touch_surface_newest_ns(touched.surface, &newest), TOUCH_OK);
        at.time_ns = newest;
        const touch_vec3 goal = goal_at(tick);
        EXPECT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
    }
    writer.join();
    EXPECT_EQ(touch_surface_newest_ns(touched.surface, &newest), TOUCH_OK);
    EXPECT_EQ(newest, (frames - 1) * 33'000'000);
}

/// Whoever tries to destroy what a solver needs gets TOUCH_BUSY, and nobody else notices.
TEST(Threads, WhatCannotBeDestroyedStaysThereForAll) {
    const TouchedHill touched;
    std::atomic<bool> over = false;
    std::thread destroyer([&] {
        while (!over)
            if (touch_surface_destroy(touched.surface) != TOUCH_BUSY) break;
    });
    int stale = 0;
    for (int k = 0; k < 100'000; ++k) {
        std::int64_t newest;
        stale += touch_surface_newest_ns(touched.surface, &newest) != TOUCH_OK;
    }
    over = true;
    destroyer.join();
    EXPECT_EQ(stale, 0);
}

}  // namespace
}  // namespace touchable::test
