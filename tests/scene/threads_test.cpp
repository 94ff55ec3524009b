// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <new>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/child_process.hpp"
#include "engine/base/threads.hpp"
#include "engine/scene/plane_memory.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(StopScope, EndsWorkAtItsDeadline) {
    EXPECT_TRUE(work_until(steady_clock::now() - milliseconds(1), stop_requested));
    EXPECT_FALSE(work_until(steady_clock::now() + std::chrono::hours(1), stop_requested));
    EXPECT_FALSE(stop_requested()) << "around it nothing is late";
}

TEST(StopScope, HidesOuterScopesForAll) {
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

TEST(StopScope, EndsByScopesAfterStop) {
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

TEST(StopScopeDeathTest, FollowsCallerAfterStop) {
    EXPECT_EXIT(work_for_all_after_a_stop(), ::testing::ExitedWithCode(0), "");
}

TEST(StopScope, ReachesRowBands) {
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

TEST(WaitUnlessStopped, EndsWithConditionOrStop) {
    int looks = 0;
    EXPECT_TRUE(wait_unless_stopped([&] { return ++looks == 3; }, milliseconds(1)));
    EXPECT_EQ(looks, 3);
    const auto never = [] { return false; };
    const auto deadline = steady_clock::now() + milliseconds(30);
    EXPECT_FALSE(work_until(deadline, [&] { return wait_unless_stopped(never, milliseconds(1)); }));
    EXPECT_GE(steady_clock::now(), deadline);
}

TEST(WaitUnlessStopped, HearsConditionVariableAndStop) {
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

TEST(WaitUnlessStopped, HearsDescriptorAndStop) {
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

TEST(WaitUnlessStopped, EndsAtMomentOrStop) {
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

TEST(UnlessStopped, PassesOnResultsAndExceptions) {
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

TEST(UnlessStopped, LeavesWorkAtDeadline) {
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

using std::chrono::milliseconds;

Result<std::string> output_of(std::vector<std::string> words, std::size_t most = 1 << 20,
                              const ChildLimits& limits = {}, const std::vector<std::string>& settings = {}) {
    auto child = ChildProcess::start(std::move(words), limits, settings);
    if (!child) return child.error();
    if (!*child) return input_error("is not there");
    return (*child)->all_output(most);
}
std::string failure_of(const Result<std::string>& output) {
    return output ? "" : output.error().message;
}
bool has_children() {
    return ::waitpid(-1, nullptr, WNOHANG) >= 0;
}

TEST(ChildProcess, GivesAllThatItWrites) {
    const auto output = output_of({"sh", "-c", "head -c 300000 /dev/zero; cat; echo end"});
    ASSERT_EQ(failure_of(output), "");
    EXPECT_EQ(output->size(), 300004U) << "standard input is empty";
    EXPECT_TRUE(output->ends_with("end\n"));
    EXPECT_FALSE(has_children());
}

TEST(ChildProcess, SaysHowItEnded) {
    EXPECT_EQ(failure_of(output_of({"sh", "-c", "echo first >&2; echo Oh no >&2; exit 3"})),
              "ended with status 3: Oh no");
    EXPECT_EQ(failure_of(output_of({"sh", "-c", "kill -9 $$"})), "ended by signal 9");
    EXPECT_EQ(failure_of(output_of({"no-such-program-here"})), "is not there");
}

TEST(ChildProcess, HasItsOwnSettings) {
    ::setenv("EXTR", "c", 1);  // its name begins another's
    const auto output = output_of({"sh", "-c", "echo $HOME-$EXTRA-$EXTR"}, 100, {}, {"HOME=a", "EXTRA=b"});
    ::unsetenv("EXTR");
    ASSERT_EQ(failure_of(output), "");
    EXPECT_EQ(*output, "a-b-c\n");
}

TEST(ChildProcess, IsBoundedInOutput) {
    EXPECT_EQ(failure_of(output_of({"yes"}, 4096)), "gives more than 4 KiB");
    EXPECT_FALSE(has_children());
}

TEST(ChildProcess, IsBoundedInItsResources) {
    const ChildLimits little{.memory_bytes = std::uint64_t{256} << 20, .processor_seconds = 0};
    const auto output =
        output_of({"sh", "-c", "sleep 0.1; dd if=/dev/zero of=/dev/null bs=1G count=1"}, 1 << 20, little);
    EXPECT_NE(failure_of(output).find("ended with status 1: dd: memory exhausted"), std::string::npos)
        << failure_of(output);
    const ChildLimits short_time{.memory_bytes = 0, .processor_seconds = 1};
    const auto endless = output_of({"sh", "-c", "while :; do :; done"}, 100, short_time);
    ASSERT_EQ(failure_of(endless), "used up its processor time");
    EXPECT_EQ(endless.error().cause, Error::Cause::out_of_time);
}

/// As in a program that links this library.
TEST(ChildProcess, EndsWithIgnoredChildren) {
    const auto before = std::signal(SIGCHLD, SIG_IGN);
    const auto output = output_of({"sh", "-c", "sleep 0.1; echo words"});
    std::signal(SIGCHLD, before);
    ASSERT_EQ(failure_of(output), "");
    EXPECT_EQ(*output, "words\n");
}

TEST(ChildProcess, AStopEndsItsOutput) {
    // One that is silent, one that writes on, one that closed its output, and one that ignores SIGTERM.
    for (const char* lines : {"sleep 1000", "while :; do echo; sleep 0.01; done", "exec >&-; sleep 1000",
                              "trap '' TERM; while :; do sleep 0.1; done"}) {
        const auto output = work_until(steady_clock::now() + milliseconds(50), [&] {
            return output_of({"sh", "-c", lines});
        });
        ASSERT_FALSE(output) << lines;
        EXPECT_EQ(output.error().kind, ErrorKind::interrupted) << lines;
    }
    EXPECT_FALSE(has_children());
}

/// Starts a shell that has said something once it is returned: its traps are set.
std::unique_ptr<ChildProcess> shell(const std::string& lines) {
    auto child = ChildProcess::start({"sh", "-c", lines});
    if (!child || !*child) return nullptr;
    std::array<std::uint8_t, 16> said;
    while ((*child)->read(said).value_or(1) == 0) std::this_thread::sleep_for(milliseconds(1));
    return std::move(*child);
}

TEST(ChildProcess, HasTimeToEnd) {
    const TemporaryFolder folder;
    const std::string file = folder / "ended";
    auto child = shell("trap 'touch " + file + "; exit' TERM; echo; while :; do sleep 0.01; done");
    ASSERT_TRUE(child);
    child.reset();
    EXPECT_TRUE(std::filesystem::exists(file));
}

TEST(ChildProcess, HasLittleTimeAtStop) {
    const TemporaryFolder folder;
    const std::string file = folder / "a-second-later";
    auto child = shell("trap '' TERM; echo; sleep 1; touch " + file + "; sleep 1000");
    ASSERT_TRUE(child);
    std::stop_source stop;
    stop.request_stop();
    work_until(stop.get_token(), [&] { child.reset(); });
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(StartThread, NamesAndRunsThread) {
    std::array<char, 16> name{};
    std::thread thread;
    ASSERT_TRUE(start_thread(thread, "fifteen-letters", "that is a test",
                             [&name] { pthread_getname_np(pthread_self(), name.data(), name.size()); }));
    thread.join();
    EXPECT_EQ(std::string(name.data()), "fifteen-letters");
}

TEST(RowBands, CoverEachRowOnce) {
    for (const auto& [threads, until_stopped] :
         {std::pair(1, false), {2, false}, {3, false}, {7, false}, {1, true}, {3, true}}) {
        RowBands bands(threads, until_stopped);
        for (const int step : {1, 3, 16})
            for (const int rows : {1, 2, 15, 16, 17, 100, 1080}) {
                std::vector<int> visits(static_cast<std::size_t>(rows));  // no two bands touch the same row
                bands.for_each_band(rows, step, [&](const RowBand& band) {
                    EXPECT_LT(band.first, band.last);
                    EXPECT_EQ(band.first % step, 0);
                    EXPECT_TRUE(band.last % step == 0 || band.last == rows);
                    for (int y = band.first; y < band.last; ++y) ++visits[static_cast<std::size_t>(y)];
                });
                EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(rows), 1))
                    << rows << ", " << step;
            }
    }
}

TEST(RowBands, RunOneBandPerThread) {
    RowBands bands(3);
    std::mutex mutex;
    std::set<int> busy, seen;
    for (int round = 0; round < 200; ++round)
        bands.for_each_band(64, 1, [&](const RowBand& band) {
            {
                const std::lock_guard lock(mutex);
                EXPECT_TRUE(busy.insert(band.thread).second);
                seen.insert(band.thread);
            }
            std::this_thread::yield();
            const std::lock_guard lock(mutex);
            busy.erase(band.thread);
        });
    for (const int thread : seen) EXPECT_TRUE(thread >= 0 && thread < 3) << thread;
}

/// One band waits until another has begun, which only another thread can have.
TEST(RowBands, UseAnotherThread) {
    RowBands bands(2);
    std::mutex mutex;
    std::condition_variable other_came;
    std::set<std::thread::id> workers;
    bands.for_each_band(64, 1, [&](const RowBand&) {
        std::unique_lock lock(mutex);
        workers.insert(std::this_thread::get_id());
        other_came.notify_all();
        other_came.wait(lock, [&] { return workers.size() == 2; });
    });
    EXPECT_EQ(workers.size(), 2U);
}

TEST(RowBands, ShowWritesToNextRun) {
    RowBands bands(3);
    std::vector<int> values(512), sums(512);
    for (int round = 1; round <= 100; ++round) {
        bands.for_each_band(512, 2, [&](const RowBand& band) {
            for (int y = band.first; y < band.last; ++y) values[static_cast<std::size_t>(y)] = round * y;
        });
        bands.for_each_band(512, 4, [&](const RowBand& band) {
            for (int y = band.first; y < band.last; ++y)
                sums[static_cast<std::size_t>(y)] =
                    values[static_cast<std::size_t>(y)] + values[static_cast<std::size_t>(511 - y)];
        });
        ASSERT_EQ(sums, std::vector<int>(512, 511 * round));
    }
}

TEST(RowBands, RunSingleBandOnCaller) {
    RowBands bands(4);
    for (int round = 0; round < 3; ++round)
        bands.for_each_band(16, 16, [caller = std::this_thread::get_id()](const RowBand& band) {
            EXPECT_EQ(std::this_thread::get_id(), caller);
            EXPECT_TRUE(band.first == 0 && band.last == 16 && band.thread == 0);
        });
}

TEST(RowBands, PassOnExceptions) {
    for (const int threads : {1, 3}) {
        RowBands bands(threads);
        for (int round = 0; round < 20; ++round) {
            auto refuse_one = [](const RowBand& band) {
                if (band.first >= 300) throw std::bad_alloc();
            };
            EXPECT_THROW(bands.for_each_band(512, 1, refuse_one), std::bad_alloc);
            std::vector<int> visits(512);
            bands.for_each_band(512, 1, [&](const RowBand& band) {
                for (int y = band.first; y < band.last; ++y) ++visits[static_cast<std::size_t>(y)];
            });
            EXPECT_EQ(visits, std::vector<int>(512, 1));
        }
    }
}

using Lease = std::shared_ptr<std::uint8_t>;

constexpr std::size_t page = 4096;
/// Free memory that the pool keeps, at most.
constexpr std::size_t bound = std::size_t{256} << 20;

std::uint64_t id_of(const Lease& lease) {
    const auto block = plane_block_of(lease.get(), 1);
    return block ? block->id() : 0;
}

/// Takes and lets go of so many other leases that a size is forgotten which is not among them.
void forget_other_sizes() {
    for (int n = 0; n < 200; ++n) take_plane_memory(page);
}

TEST(PlaneMemory, IsWholePages) {
    for (const std::size_t bytes : {std::size_t{0}, page, page + 1, 3 * page - 1, std::size_t{1} << 20}) {
        const Lease lease = take_plane_memory(bytes);
        ASSERT_NE(lease, nullptr);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lease.get()) % page, 0U);
        const auto block = plane_block_of(lease.get(), bytes);
        ASSERT_NE(block, nullptr);
        EXPECT_EQ(block->data(), lease.get());
        EXPECT_GE(block->bytes(), bytes);
        EXPECT_LT(block->bytes(), bytes + 65536);  // the largest pages of any processor here
        EXPECT_EQ(block->bytes() % page, 0U);
        std::fill_n(lease.get(), bytes, std::uint8_t{1});
    }
}

TEST(PlaneMemory, IsNullWithoutMemory) {
    EXPECT_EQ(take_plane_memory(SIZE_MAX / 2), nullptr);
    EXPECT_EQ(take_plane_memory(SIZE_MAX), nullptr);
}

TEST(PlaneMemory, UsesABlockAgain) {
    Lease lease = take_plane_memory(100'000), copy = lease;
    const std::uint64_t id = id_of(lease);
    lease.reset();
    EXPECT_EQ(id_of(copy), id);
    copy.reset();
    lease = take_plane_memory(100'001);  // as many pages
    EXPECT_EQ(id_of(lease), id);
    const Lease other = take_plane_memory(100'000);
    EXPECT_NE(id_of(other), id);
    EXPECT_NE(other.get(), lease.get());
}

TEST(PlaneMemory, BeginsWithZerosOnRequest) {
    constexpr std::size_t bytes = 5 * page - 7;
    const auto is_zero = [](std::uint8_t byte) { return byte == 0; };
    forget_other_sizes();
    std::uint64_t first = 0;
    for (int n = 0; n < 2; ++n) {
        const Lease lease = take_plane_memory(bytes, PlaneContent::zero);
        if (n == 0) first = id_of(lease);
        EXPECT_EQ(id_of(lease), first);
        EXPECT_TRUE(std::all_of(lease.get(), lease.get() + bytes, is_zero));
        std::fill_n(lease.get(), bytes, std::uint8_t{1});
    }
    EXPECT_EQ(take_plane_memory(bytes).get()[bytes - 1], 1);
}

TEST(PlaneMemory, ForgetsSizesNotAskedFor) {
    Lease lease = take_plane_memory(9 * page);
    const std::uint64_t id = id_of(lease);
    lease.reset();
    forget_other_sizes();
    EXPECT_GT(id_of(take_plane_memory(9 * page)), id);
    // Nor is one kept that comes back when its size is forgotten.
    lease = take_plane_memory(9 * page);
    const std::uint64_t late = id_of(lease);
    forget_other_sizes();
    lease.reset();
    EXPECT_GT(id_of(take_plane_memory(9 * page)), late);
}

/// What a stall of a stream made wait at once is given back when the stream flows again.
TEST(PlaneMemory, ForgetsSurplus) {
    constexpr std::size_t bytes = 11 * page;
    std::vector<Lease> leases;
    std::set<std::uint64_t> before;
    for (int n = 0; n < 6; ++n) before.insert(id_of(leases.emplace_back(take_plane_memory(bytes))));
    leases.clear();
    for (int n = 0; n < 2000; ++n) leases = {take_plane_memory(bytes), take_plane_memory(bytes)};
    for (int n = 0; n < 4; ++n) leases.push_back(take_plane_memory(bytes));
    EXPECT_EQ(
        std::ranges::count_if(leases, [&](const Lease& lease) { return before.contains(id_of(lease)); }),
        4);  // two in use, while the next two are taken
}

TEST(PlaneMemory, KeepsABoundedAmountFree) {
    forget_other_sizes();
    constexpr std::size_t bytes = bound / 4;
    std::vector<Lease> leases;
    std::set<std::uint64_t> before, again;
    for (int n = 0; n < 6; ++n) before.insert(id_of(leases.emplace_back(take_plane_memory(bytes))));
    leases.clear();
    for (int n = 0; n < 6; ++n) {
        const std::uint64_t id = id_of(leases.emplace_back(take_plane_memory(bytes)));
        if (before.contains(id)) again.insert(id);
    }
    // The smallest pages of the test's other leases may be free, too.
    EXPECT_GE(again.size(), 3U);
    EXPECT_LE(again.size(), 4U);
    leases.clear();
    forget_other_sizes();
}

TEST(PlaneMemory, KnowsBlocksOfPlanes) {
    const Lease lease = take_plane_memory(4 * page);
    const auto block = plane_block_of(lease.get(), 4 * page);
    ASSERT_NE(block, nullptr);
    const std::uint8_t *const begin = block->data(), *const end = begin + block->bytes();
    EXPECT_EQ(plane_block_of(begin + page, page), block);
    EXPECT_EQ(plane_block_of(end - 1, 1), block);
    EXPECT_EQ(plane_block_of(end - 1, 2), nullptr);
    EXPECT_EQ(plane_block_of(begin, block->bytes() + 1), nullptr);
    EXPECT_EQ(plane_block_of(begin, SIZE_MAX), nullptr);
    EXPECT_NE(plane_block_of(begin - 1, 2), block);
    EXPECT_NE(plane_block_of(end, 1), block);
    const std::vector<std::uint8_t> other(4 * page);
    EXPECT_EQ(plane_block_of(other.data(), other.size()), nullptr);
    EXPECT_EQ(plane_block_of(nullptr, 1), nullptr);
}

TEST(PlaneMemory, StaysMappedWhileHeld) {
    Lease lease = take_plane_memory(7 * page);
    auto block = plane_block_of(lease.get(), 7 * page);
    std::uint8_t* const data = lease.get();
    const auto is_mapped = [&] { return msync(data, 7 * page, MS_ASYNC) == 0; };
    lease.reset();
    EXPECT_EQ(plane_block_of(data, 1), nullptr) << "no plane lies there";
    lease = take_plane_memory(7 * page);
    EXPECT_EQ(id_of(lease), block->id()) << "a block that is held is lent all the same";
    lease.reset();
    forget_other_sizes();
    EXPECT_TRUE(is_mapped());
    block.reset();
    EXPECT_FALSE(is_mapped());
}

TEST(PlaneMemory, BelongsToOneThread) {
    constexpr int threads = 4, rounds = 2000, held = 3;
    const auto work = [](int number, bool& is_own) {
        const auto mark = static_cast<std::uint8_t>(number + 1);
        std::vector<Lease> leases(held);
        for (int n = 0; n < rounds; ++n) {
            // Other threads have these sizes, too.
            const std::size_t bytes = (1 + static_cast<std::size_t>(n % 3)) * page;
            Lease& lease = leases[static_cast<std::size_t>(n % held)];
            lease = take_plane_memory(bytes);
            std::fill_n(lease.get(), bytes, mark);
            for (const Lease& kept : leases)
                is_own = is_own && (!kept || (kept.get()[0] == mark && kept.get()[page - 1] == mark));
            const auto block = plane_block_of(lease.get(), bytes);
            is_own = is_own && block && block->data() == lease.get();
        }
    };
    bool own[threads] = {true, true, true, true};
    std::vector<std::thread> all;
    for (int n = 0; n < threads; ++n) all.emplace_back(work, n, std::ref(own[n]));
    for (std::thread& thread : all) thread.join();
    for (const bool is_own : own) EXPECT_TRUE(is_own);
}

}  // namespace
}  // namespace touchable::test
