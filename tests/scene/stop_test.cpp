#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <stop_token>
#include <thread>

#include "engine/base/threads.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(StopScope, EndsWorkAtItsDeadline) {
    EXPECT_TRUE(work_until(steady_clock::now() - milliseconds(1), stop_requested));
    EXPECT_FALSE(work_until(steady_clock::now() + std::chrono::hours(1), stop_requested));
    EXPECT_FALSE(stop_requested()) << "around it nothing is late";
}

TEST(StopScope, ForAllLeavesOutWhatIsAround) {
    std::stop_source given_up, within;
    given_up.request_stop();
    const StopScope outer(given_up.get_token());
    {
        const StopScope for_all = StopScope::for_all();
        EXPECT_FALSE(stop_requested());
        const StopScope inner(within.get_token());
        EXPECT_FALSE(stop_requested());
        within.request_stop();
        EXPECT_TRUE(stop_requested()) << "but not what lies within";
    }
    EXPECT_TRUE(stop_requested());
}

TEST(StopScope, AfterStopStillEndsByItsScopes) {
    std::stop_source given_up;
    const StopScope goes_on = StopScope::after_stop();
    const StopScope until(given_up.get_token());
    EXPECT_FALSE(stop_requested());
    given_up.request_stop();
    EXPECT_TRUE(stop_requested());
}

/// Ends the process: 0 where work for all goes on after a stop exactly as its caller does.
[[noreturn]] void work_for_all_after_a_stop() {
    request_stop();
    {
        const StopScope for_all = StopScope::for_all();
        if (!stop_requested()) std::_Exit(2);
    }
    const StopScope goes_on = StopScope::after_stop();
    const StopScope for_all = StopScope::for_all();
    std::_Exit(stop_requested() ? 3 : 0);
}

TEST(StopScopeDeathTest, ForAllGoesOnAfterAStopOnlyWhereItsCallerDoes) {
    EXPECT_EXIT(work_for_all_after_a_stop(), ::testing::ExitedWithCode(0), "");
}

TEST(StopScope, RowBandsTakeOnTheCallers) {
    constexpr int rows = 64;
    std::stop_source given_up;
    given_up.request_stop();
    RowBands bands(3);
    std::atomic<int> asked{0}, heard{0}, of_others{0};
    auto ask = [&](const RowBand& band) {
        ++asked;
        heard += stop_requested() ? 1 : 0;
        of_others += band.thread > 0 ? 1 : 0;
        if (band.thread == 0)  // the others have time to take one
            for (int k = 0; k < 60'000 && of_others == 0; ++k) std::this_thread::sleep_for(milliseconds(1));
    };
    work_until(given_up.get_token(), [&] { bands.for_each_band(rows, 1, ask); });
    EXPECT_GT(of_others, 0);
    EXPECT_EQ(heard, asked);
    heard = 0;
    bands.for_each_band(rows, 1, ask);
    EXPECT_EQ(heard, 0) << "and let go of it";
}

TEST(WaitUnlessStopped, EndsWithItsConditionOrAStop) {
    int looks = 0;
    EXPECT_TRUE(wait_unless_stopped([&] { return ++looks == 3; }, milliseconds(1)));
    EXPECT_EQ(looks, 3);
    const auto never = [] { return false; };
    const auto deadline = steady_clock::now() + milliseconds(30);
    EXPECT_FALSE(work_until(deadline, [&] { return wait_unless_stopped(never, milliseconds(1)); }));
    EXPECT_GE(steady_clock::now(), deadline);
}

TEST(WaitUnlessStopped, HearsAConditionVariableAndAStop) {
    std::mutex mutex;
    std::condition_variable changed;
    bool is_there = false;
    std::thread other([&] {
        const std::lock_guard lock(mutex);
        is_there = true;
        changed.notify_one();
    });
    {
        std::unique_lock lock(mutex);
        EXPECT_TRUE(wait_unless_stopped(changed, lock, [&] { return is_there; }));
        EXPECT_TRUE(lock.owns_lock());
        std::stop_source given_up;
        given_up.request_stop();
        const StopScope until(given_up.get_token());
        EXPECT_FALSE(wait_unless_stopped(changed, lock, [] { return false; }));
        EXPECT_TRUE(lock.owns_lock());
    }
    other.join();
}

TEST(WaitUnlessStopped, HearsADescriptorAndAStop) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    EXPECT_TRUE(wait_unless_stopped(ends[1], POLLOUT));
    const auto deadline = steady_clock::now() + milliseconds(30);
    EXPECT_FALSE(work_until(deadline, [&] { return wait_unless_stopped(ends[0], POLLIN); }));
    ASSERT_EQ(::write(ends[1], "a", 1), 1);
    EXPECT_TRUE(wait_unless_stopped(ends[0], POLLIN));
    ::close(ends[1]);
    ::close(ends[0]);
    EXPECT_TRUE(wait_unless_stopped(ends[0], POLLIN)) << "a closed one is of no use any more";
}

TEST(WaitUnlessStopped, EndsAtItsMomentOrAStop) {
    const auto moment = steady_clock::now() + milliseconds(30);
    EXPECT_TRUE(wait_unless_stopped(moment));
    EXPECT_GE(steady_clock::now(), moment);
    const auto deadline = steady_clock::now() + milliseconds(30);
    EXPECT_FALSE(work_until(deadline, [] { return wait_unless_stopped(steady_clock::time_point::max()); }));
    EXPECT_FALSE(work_until(deadline, [&] { return wait_unless_stopped(moment); }))
        << "also of one that is past";
}

void await_abandoned() {
    for (int k = 0; k < 60'000 && abandoned_threads > 0; ++k) std::this_thread::sleep_for(milliseconds(1));
    EXPECT_EQ(abandoned_threads, 0);
}

TEST(UnlessStopped, GivesWhatWorkGivesOrThrows) {
    EXPECT_EQ(unless_stopped([] { return 7; }), 7);
    EXPECT_THROW((void)unless_stopped([]() -> int { throw std::bad_alloc(); }), std::bad_alloc);
}

/// Abandoned work can ask only its own thread whether to stop.
TEST(UnlessStopped, AbandonedWorkHearsIt) {
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    const auto has_ended = std::make_shared<std::atomic<bool>>(false);
    const auto made = unless_stopped([given_up, has_ended]() mutable {
        given_up.request_stop();
        for (int k = 0; k < 60'000 && !stop_requested(); ++k) std::this_thread::sleep_for(milliseconds(1));
        *has_ended = stop_requested();
        return 7;
    });
    EXPECT_FALSE(made);
    await_abandoned();
    EXPECT_TRUE(*has_ended);
}

TEST(UnlessStopped, LeavesWorkBehindAtADeadline) {
    const auto may_end = std::make_shared<std::atomic<bool>>(false);
    const auto made = work_until(steady_clock::now() + milliseconds(30), [&] {
        return unless_stopped([may_end] {
            for (int k = 0; k < 60'000 && !*may_end; ++k) std::this_thread::sleep_for(milliseconds(1));
            return 7;
        });
    });
    EXPECT_FALSE(made);
    EXPECT_FALSE(stop_requested());
    EXPECT_EQ(abandoned_threads, 1);
    *may_end = true;
    await_abandoned();
}

}  // namespace
}  // namespace touchable::test
