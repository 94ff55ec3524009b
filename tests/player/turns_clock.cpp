// SPDX-License-Identifier: Apache-2.0
// Loaded before a program whose window goes by a script: time waits for the window. Its clocks go as the
// machine's do while its first thread, which takes the script and draws, looks at them every 20 ms. While
// that thread is kept from it for longer, by a machine that is busy with others or by a large picture, they
// go 64 times slower. So a script meets the same window on a machine of any speed. All threads of the
// program, and processes that it forks, have the same clocks, and waits that end at a moment end by them.
#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000, ns_per_us = 1'000;
constexpr std::int64_t turn_ns = 20'000'000, slower = 64;

std::int64_t ns_of(const timespec& time) {
    return time.tv_sec * ns_per_s + time.tv_nsec;
}

timespec time_of(std::int64_t ns) {
    return {ns / ns_per_s, ns % ns_per_s};
}

template <class Function>
Function next(Function, const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

std::int64_t machine_ns(clockid_t clock) {
    static const auto ask = next(&clock_gettime, "clock_gettime");
    timespec now{};
    ask(clock, &now);
    return ns_of(now);
}

/// State that all threads and forks look at.
struct Shared {
    /// As the first thread left it when it looked last, in microseconds (for an hour): above, how far the
    /// clocks are behind the machine's, below, when that was, since `begin_ns`. In one word, so that no
    /// thread waits for another.
    std::atomic<std::uint64_t> behind_and_looked{0};
    std::int64_t begin_ns = 0, suspended_ns = 0;
};
Shared* shared = nullptr;
bool is_fork = false;
pthread_t first_thread;

[[gnu::constructor]] void begin() {
    unsetenv("LD_PRELOAD");  // other programs that this one starts have no window
    void* const room =
        mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED) std::abort();
    auto* const made = new (room) Shared;
    made->begin_ns = machine_ns(CLOCK_MONOTONIC);
    made->suspended_ns = machine_ns(CLOCK_BOOTTIME) - made->begin_ns;
    first_thread = pthread_self();
    pthread_atfork(nullptr, nullptr, [] { is_fork = true; });
    shared = made;
}

/// Time that the clocks show at that moment of the machine's, which is looked at after `last`: so no thread
/// sees them go back.
std::int64_t shown_ns(std::uint64_t last, std::int64_t machine) {
    const std::int64_t behind = static_cast<std::int64_t>(last >> 32) * ns_per_us,
                       looked = static_cast<std::int64_t>(last & 0xffff'ffff) * ns_per_us,
                       since = machine - shared->begin_ns;
    const std::int64_t all =
        behind + std::max<std::int64_t>(0, since - looked - turn_ns) / slower * (slower - 1);
    if (!is_fork && pthread_equal(pthread_self(), first_thread))
        shared->behind_and_looked =
            static_cast<std::uint64_t>(all / ns_per_us) << 32 | static_cast<std::uint64_t>(since / ns_per_us);
    return machine - all;
}

std::int64_t shown_ns() {
    const std::uint64_t last = shared->behind_and_looked;
    return shown_ns(last, machine_ns(CLOCK_MONOTONIC));
}

/// Calls `wait` with a moment of the machine's clock, until the clocks show `until_ns` or it ends for another
/// reason than the time.
template <class Wait>
int wait_until(std::int64_t until_ns, int time_is_up, const Wait& wait) {
    while (true) {
        const std::int64_t left = until_ns - shown_ns(), least = 50 * ns_per_us;  // while they are slow
        const int ended = wait(time_of(machine_ns(CLOCK_MONOTONIC) + (left > 0 ? std::max(left, least) : 0)));
        if (ended != time_is_up || left <= 0) return ended;
    }
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
    static const auto ask = next(&clock_gettime, "clock_gettime");
    if (!shared || (clock != CLOCK_MONOTONIC && clock != CLOCK_BOOTTIME)) return ask(clock, time);
    *time = time_of(shown_ns() + (clock == CLOCK_BOOTTIME ? shared->suspended_ns : 0));
    return 0;
}

extern "C" int clock_nanosleep(clockid_t clock, int flags, const timespec* time, timespec* left) {
    static const auto sleep = next(&clock_nanosleep, "clock_nanosleep");
    if (clock != CLOCK_MONOTONIC || (flags & TIMER_ABSTIME) == 0) return sleep(clock, flags, time, left);
    return wait_until(ns_of(*time), 0,
                      [&](const timespec& until) { return sleep(clock, flags, &until, left); });
}

extern "C" int pthread_cond_clockwait(pthread_cond_t* told, pthread_mutex_t* mutex, clockid_t clock,
                                      const timespec* time) {
    static const auto wait = next(&pthread_cond_clockwait, "pthread_cond_clockwait");
    if (clock != CLOCK_MONOTONIC) return wait(told, mutex, clock, time);
    return wait_until(ns_of(*time), ETIMEDOUT,
                      [&](const timespec& until) { return wait(told, mutex, clock, &until); });
}
