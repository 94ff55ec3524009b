// SPDX-License-Identifier: Apache-2.0
// The real-time thread: what it promises at any load of the machine. No test here depends on a deadline
// being met.

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include "engine/run/touch_run.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/limits.hpp"

namespace touchable::test {
namespace {

/// Goals that press into a wall; remembers what was written.
class PressingPort final : public HapticPort {
public:
    bool read_goals(std::int64_t tick, const HeightField&, std::span<dvec3> goals) override {
        ticks.push_back(tick);
        if (static_cast<int>(ticks.size()) == stalls_at) std::this_thread::sleep_for(stall);
        if (static_cast<int>(ticks.size()) == throws_at) throw std::runtime_error("unplugged");
        cpus.push_back(sched_getcpu());
        for (dvec3& goal : goals)
            goal = {0, 0, -100 - 0.02 * static_cast<double>(std::min<std::int64_t>(tick, 100))};
        return static_cast<int>(ticks.size()) != fails_at;
    }
    void come_back(std::int64_t alone_ms) override {
        alone.emplace_back(static_cast<std::int64_t>(ticks.size()), alone_ms);
    }
    bool write_forces(std::span<const dvec3> newtons) override {
        last.assign(newtons.begin(), newtons.end());
        for (const dvec3& force : newtons) largest = std::max(largest, force.z);
        ++writes;
        if (writes == write_stalls_at) std::this_thread::sleep_for(stall);
        if (writes == write_throws_at) throw 7;
        return true;
    }

    int fails_at = -1, stalls_at = -1, throws_at = -1, write_stalls_at = -1, write_throws_at = -1;
    std::chrono::milliseconds stall{5};
    std::vector<std::int64_t> ticks;
    std::vector<std::pair<std::int64_t, std::int64_t>> alone;  // after how many ticks, for how many ms
    std::vector<int> cpus;                                     // that each tick began on
    std::vector<dvec3> last;
    double largest = 0;
    int writes = 0;
};

class LoopRig {
public:
    explicit LoopRig(int log_ticks, std::unique_ptr<VertexSource> vertices = std::make_unique<ExactVertices>(
                                        17, 17, std::vector<double>(17 * 17, 100.0)))
        : wall(17, 17, 100.0),
          log(log_ticks, 2) {
        SurfaceFrame* slot = surface.timeline().acquire();
        slot->width = slot->height = 17;
        slot->coding = wall.scene.depth;
        slot->vertices = std::move(vertices);
        EXPECT_TRUE(surface.timeline().publish(0, 0));
    }
    void run_to_end() {
        ASSERT_TRUE(loop.start());
        while (loop.running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        loop.stop();
    }
    void run_for(std::int64_t ns) const {
        while (loop.time_ns() < ns) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    bool is_unpowered() const { return port.last == std::vector<dvec3>(2, dvec3(0.0)); }
    template <class Take>
    void for_each_logged(Take take) {
        while (log.pop(take)) {
        }
    }

    SmallField wall;
    SurfaceQueue surface{wall.scene, nullptr};
    TouchRun run{surface, nullptr, TouchSolver::create(wall.scene, {}).value(), GuardSettings{}, 2};
    TickLog log;
    PressingPort port;
    HapticLoop loop{run.ticks(), port, log};
};

TEST(HapticLoop, LogsTicksAndEndsUnpowered) {
    LoopRig rig(4096);
    ASSERT_TRUE(rig.loop.start());
    std::vector<std::int64_t> logged;
    double largest = 0;
    while (largest < 0.5) {
        rig.log.pop([&](const TouchTick& tick) {
            logged.push_back(tick.tick);
            EXPECT_EQ(tick.contacts.size(), 2U);
            EXPECT_EQ(tick.time_ns, tick.tick * 1'000'000);
            EXPECT_FALSE(tick.behind);
            largest = std::max(largest, tick.forces[1].force.z);
        });
    }
    rig.loop.stop();
    rig.for_each_logged([&](const TouchTick& tick) { logged.push_back(tick.tick); });
    EXPECT_FALSE(rig.loop.running());
    EXPECT_EQ(logged, rig.port.ticks);
    for (std::size_t k = 1; k < logged.size(); ++k) EXPECT_GT(logged[k], logged[k - 1]);
    const HapticLoop::Facts& facts = rig.loop.facts();
    EXPECT_EQ(facts.ticks, static_cast<std::int64_t>(logged.size()));
    EXPECT_EQ(facts.skipped, logged.back() + 1 - facts.ticks) << "a tick is run or counted as skipped";
    EXPECT_EQ(facts.lost, 0);
    EXPECT_GT(rig.port.largest, 0.4);
    EXPECT_TRUE(rig.is_unpowered());
    EXPECT_EQ(rig.port.writes, facts.ticks + 1);
}

TEST(HapticLoop, ReportsFirstTickTime) {
    LoopRig rig(4096);
    EXPECT_FALSE(rig.loop.zero());
    const auto before = std::chrono::steady_clock::now();
    ASSERT_TRUE(rig.loop.start());
    rig.run_for(3'000'000);
    ASSERT_TRUE(rig.loop.zero());
    EXPECT_GE(*rig.loop.zero(), before);
    EXPECT_LE(*rig.loop.zero(), std::chrono::steady_clock::now() - std::chrono::milliseconds(3));
    rig.loop.stop();
}

TEST(HapticLoop, StaysOnNamedCpu) {
    LoopRig rig(64);
    rig.port.fails_at = 20;
    rig.run_to_end();
    const RealtimeGrant& grant = rig.loop.facts().grant;
    cpu_set_t allowed;
    ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
    if (CPU_COUNT(&allowed) < 2 || sched_setaffinity(0, sizeof(allowed), &allowed) != 0)
        GTEST_SKIP() << "this machine has one CPU, or lets no thread choose: " << grant.in_words();
    ASSERT_GE(grant.cpu, 0) << grant.in_words();
    EXPECT_EQ(rig.port.cpus, std::vector<int>(20, grant.cpu));
    EXPECT_NE(grant.in_words().find("on CPU " + std::to_string(grant.cpu)), std::string::npos);
}

TEST(HapticLoop, LostDeviceEndsUnpowered) {
    LoopRig rig(4096);
    rig.port.fails_at = 5;
    rig.run_to_end();
    EXPECT_TRUE(rig.loop.facts().port_failed);
    EXPECT_EQ(rig.port.ticks.size(), 5U);
    EXPECT_TRUE(rig.is_unpowered());
}

TEST(HapticLoop, ThrowingPortIsLostDevice) {
    for (const bool writing : {false, true}) {
        LoopRig rig(4096);
        (writing ? rig.port.write_throws_at : rig.port.throws_at) = 150;
        rig.run_to_end();
        EXPECT_TRUE(rig.loop.facts().port_failed);
        EXPECT_FALSE(rig.loop.facts().broke_off);
        EXPECT_EQ(rig.port.ticks.size(), 150U);
        EXPECT_GT(rig.port.largest, 0.5) << "there was a force to take away";
        EXPECT_TRUE(rig.is_unpowered());
    }
}

/// A surface that breaks while it is touched.
class BreakingVertices final : public VertexSource {
public:
    DepthSample at(int x, int y) const override {
        if (++calls_ > 5000) throw std::bad_alloc();
        return wall_.at(x, y);
    }
    TileDepths tile(int tx, int ty) const override { return wall_.tile(tx, ty); }

private:
    ExactVertices wall_{17, 17, std::vector<double>(17 * 17, 100.0)};
    mutable std::int64_t calls_ = 0;
};

TEST(HapticLoop, FaultEndsUnpowered) {
    LoopRig rig(4096, std::make_unique<BreakingVertices>());
    rig.run_to_end();
    EXPECT_TRUE(rig.loop.facts().broke_off);
    EXPECT_FALSE(rig.loop.facts().port_failed);
    EXPECT_TRUE(rig.is_unpowered());
}

// The fingers would go on as they were left, with the force they had, and without a ramp.
TEST(HapticLoop, RunsOnceAndSaysSo) {
    LoopRig rig(4096);
    rig.loop.stop();
    ASSERT_TRUE(rig.loop.start()) << "that it was stopped before it started is no matter";
    EXPECT_FALSE(rig.loop.start()) << "it runs";
    rig.run_for(10'000'000);
    rig.loop.stop();
    const std::int64_t ticks = rig.loop.facts().ticks;
    EXPECT_GE(rig.port.writes, 2);
    const auto again = rig.loop.start();
    ASSERT_FALSE(again);
    EXPECT_NE(again.error().message.find("runs once"), std::string::npos);
    EXPECT_FALSE(rig.loop.running());
    EXPECT_EQ(rig.loop.facts().ticks, ticks);
}

// However busy the machine is, a tick begins within its own millisecond, for a later one is the next.
TEST(HapticLoop, SkipsMissedTicks) {
    for (const int ms : {2, 5}) {
        LoopRig rig(4096);
        rig.port.stalls_at = 10;
        rig.port.stall = std::chrono::milliseconds(ms);
        rig.port.fails_at = 60;
        rig.run_to_end();
        EXPECT_GE(rig.port.ticks[10] - rig.port.ticks[9], ms);
        EXPECT_GE(rig.loop.facts().late, 1);
        EXPECT_GE(rig.loop.facts().skipped, ms - 1);
        EXPECT_EQ(rig.loop.facts().skipped, rig.port.ticks.back() + 1 - rig.loop.facts().ticks);
        int logged = 0;
        rig.for_each_logged([&](const TouchTick& tick) {
            ++logged;
            EXPECT_GE(tick.late_us, 0);
            EXPECT_LT(tick.late_us, 1000) << "tick " << tick.tick;
        });
        EXPECT_EQ(logged, 59);
    }
}

TEST(HapticLoop, MeasuresLongestPortTime) {
    LoopRig rig(4096);
    rig.port.stalls_at = rig.port.write_stalls_at = 10;
    rig.port.fails_at = 40;
    rig.run_to_end();
    EXPECT_GE(rig.loop.facts().longest_port_ms, 10) << "5 ms each, ticks ago";
}

TEST(HapticLoop, EndsBeforeGivenTick) {
    LoopRig rig(4096);
    rig.loop.end_before(30);
    rig.run_to_end();
    EXPECT_LT(rig.port.ticks.back(), 30);
    EXPECT_EQ(rig.loop.facts().ticks, static_cast<std::int64_t>(rig.port.ticks.size()));
    EXPECT_TRUE(rig.is_unpowered());
    EXPECT_FALSE(rig.loop.facts().port_failed);
}

// A machine that is suspended stops the clock that ticks go by, and another one goes on.
TEST(HapticLoop, ComesBackAfterSuspension) {
    LoopRig rig(4096);
    rig.port.fails_at = 300;
    std::int64_t now_ns = 5, reads = 0;
    rig.loop.see_gaps_by([&] {
        ++reads;
        return now_ns += reads == 150 ? 3'000'000'000 : reads == 200 ? 50'000'000 : 1'000'000;
    });
    rig.run_to_end();
    // The first reading is before the first tick.
    EXPECT_EQ(rig.port.alone, (std::vector<std::pair<std::int64_t, std::int64_t>>{{148, 3000}}));
    EXPECT_EQ(rig.loop.facts().gaps, 1);
    std::size_t ticks = 0;
    rig.for_each_logged([&](const TouchTick& tick) {
        const bool after_gap = ticks++ == 148;
        for (const GuardedForce& force : tick.forces) {
            EXPECT_EQ((force.reasons & guard_gap) != 0, after_gap) << ticks;
            EXPECT_TRUE(!after_gap || force.force == dvec3(0.0));
        }
    });
    EXPECT_GT(rig.port.largest, 0.5) << "there was a force to take away";
}

TEST(HapticLoop, UnreadLogCostsNoForce) {
    LoopRig rig(8);
    ASSERT_TRUE(rig.loop.start());
    rig.run_for(50'000'000);
    rig.loop.stop();
    EXPECT_EQ(rig.loop.facts().lost, std::max<std::int64_t>(0, rig.loop.facts().ticks - 8));
    EXPECT_EQ(rig.port.writes, rig.loop.facts().ticks + 1);
}

TEST(HapticLoop, StopsWhereItNeverStarted) {
    LoopRig rig(8);
    rig.loop.stop();
    EXPECT_FALSE(rig.loop.running());
    EXPECT_EQ(rig.port.writes, 0);
}

TEST(TickLog, DeliversWholeTicksInOrder) {
    constexpr std::int64_t count = 200'000;
    TickLog log(16, 3);
    std::atomic<std::int64_t> refused{0};
    std::thread writer([&] {
        std::vector<dvec3> goals(3);
        std::vector<Contact> contacts(3);
        std::vector<GuardedForce> forces(3);
        for (std::int64_t k = 0; k < count;) {
            for (auto& goal : goals) goal.x = static_cast<double>(k);
            for (auto& contact : contacts) contact.force.y = static_cast<double>(2 * k);
            for (auto& force : forces) force.force.z = static_cast<double>(3 * k);
            TouchTick tick;
            tick.tick = k;
            tick.goals = goals;
            tick.contacts = contacts;
            tick.forces = forces;
            if (log.push(tick))
                ++k;
            else
                ++refused;
        }
    });
    std::int64_t next = 0, torn = 0;
    while (next < count)
        log.pop([&](const TouchTick& tick) {
            torn += tick.tick != next;
            for (std::size_t f = 0; f < 3; ++f)
                torn += tick.goals[f].x != static_cast<double>(next) ||
                        tick.contacts[f].force.y != static_cast<double>(2 * next) ||
                        tick.forces[f].force.z != static_cast<double>(3 * next);
            ++next;
        });
    writer.join();
    EXPECT_EQ(torn, 0);
    EXPECT_GT(refused, 0) << "the writer never met a full ring";
}

// Requests of a real-time thread to its machine. Each test runs in a process of its own, for what is granted
// stays.

constexpr int right = 0, wrong = 1, not_here = 2;

/// The exit code of a child that does `work`.
template <class Work>
int in_a_child(Work work) {
    const pid_t child = fork();
    if (child == 0) _exit(work());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

long locked_kib() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmLck:")) return std::stol(line.substr(6));
    return -1;
}

/// New memory, its first page touched; false where there is none.
bool take_memory(std::size_t bytes) {
    void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return false;
    *static_cast<volatile char*>(memory) = 1;
    return true;
}

TEST(Realtime, LocksLaterMemory) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take every call that locks memory for themselves";
#endif
    const int said = in_a_child([] {
        const RealtimeGrant grant = become_realtime();
        if (grant.memory != RealtimeGrant::Memory::all) return not_here;
        const long before = locked_kib();
        if (!take_memory(std::size_t{64} << 20)) return wrong;
        const bool named = grant.in_words().find(", memory locked,") != std::string::npos;
        return named && locked_kib() - before >= 64 * 1024 ? right : wrong;
    });
    if (said == not_here) GTEST_SKIP() << "this machine does not let all memory be locked";
    EXPECT_EQ(said, right);
}

/// How much of a library's code lies in memory, and its size, KiB.
std::pair<long, long> code_in_memory(std::string_view library) {
    std::ifstream maps("/proc/self/smaps");
    bool within = false;
    std::pair<long, long> kib{0, 0};
    for (std::string line; std::getline(maps, line);) {
        if (line.find(" r-xp ") != line.npos) within = line.find(library) != line.npos;
        if (line.find(" r--p ") != line.npos || line.find(" rw-p ") != line.npos) within = false;
        if (within && line.starts_with("Rss:")) kib.first += std::stol(line.substr(4));
        if (within && line.starts_with("Size:")) kib.second += std::stol(line.substr(5));
    }
    return kib;
}

TEST(Realtime, LoadsWhatTicksCall) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take every call that locks memory for themselves";
#endif
    const int said = in_a_child([] {
        if (dlopen("libvulkan.so.1", RTLD_LAZY) == nullptr) return not_here;
        if (become_realtime().memory == RealtimeGrant::Memory::none) return not_here;
        for (const char* library : {"/libc.so", "/libm.so", "/libstdc++.so"}) {
            const auto [loaded, size] = code_in_memory(library);
            if (loaded == 0 || loaded != size) return wrong;
        }
        const auto [loaded, size] = code_in_memory("/libvulkan.so");
        return loaded < size ? right : wrong;
    });
    if (said == not_here) GTEST_SKIP() << "this machine does not let memory be locked, or has no Vulkan";
    EXPECT_EQ(said, right);
}

TEST(Realtime, NamesMemoryLimit) {
    const int said = in_a_child([] {
        rlimit limit{};
        getrlimit(RLIMIT_MEMLOCK, &limit);
        limit.rlim_cur = limit.rlim_max = std::min(limit.rlim_max, rlim_t{1} << 30);
        if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0) return not_here;
        if (geteuid() == 0 && setuid(65534) != 0) return not_here;  // root is above limits
        const RealtimeGrant grant = become_realtime();
        if (grant.memory == RealtimeGrant::Memory::all || grant.memory_limit != limit.rlim_cur) return wrong;
        const std::string named = "RLIMIT_MEMLOCK is " + std::to_string(limit.rlim_cur / 1024) + " KiB";
        if (grant.in_words().find(named) == std::string::npos) return wrong;
        return take_memory(std::size_t{3} << 29) ? right : wrong;
    });
    if (said == not_here) GTEST_SKIP() << "this machine does not let the limit be set";
    EXPECT_EQ(said, right);
}

TEST(Realtime, NamesUnlockedMemory) {
    const auto words = [](RealtimeGrant::Memory memory, std::optional<std::uint64_t> limit) {
        RealtimeGrant grant;
        grant.memory = memory;
        grant.memory_limit = limit;
        return grant.in_words();
    };
    const auto has = [](const std::string& text, const char* part) { return text.find(part) != text.npos; };
    using Memory = RealtimeGrant::Memory;
    EXPECT_TRUE(has(words(Memory::none, 65536), ", memory not locked (RLIMIT_MEMLOCK is 64 KiB),"));
    EXPECT_TRUE(has(words(Memory::none, std::nullopt), ", memory not locked (not permitted),"));
    EXPECT_TRUE(has(words(Memory::present, 65536),
                    ", memory locked but what came after the start (RLIMIT_MEMLOCK is 64 KiB),"));
}

}  // namespace
}  // namespace touchable::test
