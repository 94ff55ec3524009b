#include "haptics_cpu/realtime.hpp"

#include <link.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <string_view>

namespace touchable {

namespace {

std::string memory_in_words(const RealtimeGrant& grant) {
    if (grant.memory == MemoryLock::all) return "memory locked";
    const std::string limit = grant.memory_limit
                                  ? "RLIMIT_MEMLOCK is " + std::to_string(*grant.memory_limit / 1024) + " KiB"
                                  : "not permitted";
    if (grant.memory == MemoryLock::none) return "memory not locked (" + limit + ")";
    return "memory locked but what came after the start (" + limit + ")";
}

/// Whether memory may be locked beyond a limit, as whoever has CAP_IPC_LOCK may: tried on addresses with
/// nothing behind them.
bool may_lock_beyond(std::uint64_t limit) {
    const std::size_t bytes = limit + (std::size_t{1} << 20);
    void* nothing = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (nothing == MAP_FAILED) return false;
    const bool may = mlock2(nothing, bytes, MLOCK_ONFAULT) == 0;
    munmap(nothing, bytes);
    return may;
}

/// How much memory this process may lock, with the limit raised as far as that is allowed.
std::optional<std::uint64_t> memory_limit() {
    rlimit limit{};
    getrlimit(RLIMIT_MEMLOCK, &limit);
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_MEMLOCK, &limit);
    if (limit.rlim_cur == RLIM_INFINITY || may_lock_beyond(limit.rlim_cur)) return std::nullopt;
    return limit.rlim_cur;
}

/// Code and data of the program, which has no name here, and of the libraries that a tick may call: fetched
/// and kept, so that no tick waits for them.
int lock_for_ticks(dl_phdr_info* object, std::size_t, void*) {
    const std::string_view name = object->dlpi_name;
    const auto is_part = [name](const char* library) { return name.find(library) != std::string_view::npos; };
    if (!name.empty() && !is_part("/libc.so") && !is_part("/libm.so") && !is_part("/libstdc++.so")) return 0;
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    for (int k = 0; k < object->dlpi_phnum; ++k) {
        const auto& segment = object->dlpi_phdr[k];
        if (segment.p_type != PT_LOAD) continue;
        const std::uintptr_t begin = (object->dlpi_addr + segment.p_vaddr) / page * page;
        const std::uintptr_t end = object->dlpi_addr + segment.p_vaddr + segment.p_memsz;
        mlock(reinterpret_cast<const void*>(begin), end - begin);
    }
    return 0;
}

/// As much of the calling thread's stack as a tick could want.
unsigned char touch_stack() {
    constexpr std::size_t depth = 256 * 1024, page = 4096;
    volatile unsigned char below[depth];
    for (std::size_t at = 0; at < depth; at += page) below[at] = 0;
    return below[0];
}

/// What is there is kept, and what comes later once somebody has touched it, as a builder does with its
/// frames before the hand sees them: to fetch all of it at once would fetch what drivers and libraries only
/// reserve, and eight megabytes of stack for every thread. Below a finite limit nothing is asked for later
/// memory, because what would go beyond it is refused altogether.
MemoryLock lock_memory(bool limited) {
    if (mlockall(MCL_CURRENT | MCL_ONFAULT) != 0) return MemoryLock::none;
    dl_iterate_phdr(lock_for_ticks, nullptr);
    touch_stack();
    if (limited || mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return MemoryLock::present;
    return MemoryLock::all;
}

/// The CPU the calling thread is pinned to; -1 where it has only one, or may not choose.
int stay_on_last_cpu() {
    cpu_set_t allowed;
    if (pthread_getaffinity_np(pthread_self(), sizeof(allowed), &allowed) != 0 || CPU_COUNT(&allowed) < 2)
        return -1;
    int last = CPU_SETSIZE - 1;
    while (!CPU_ISSET(last, &allowed)) --last;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(last, &one);
    return pthread_setaffinity_np(pthread_self(), sizeof(one), &one) == 0 ? last : -1;
}

}  // namespace

std::string RealtimeGrant::in_words() const {
    const std::string scheduling = fifo ? "SCHED_FIFO" : "normal scheduling (SCHED_FIFO is not permitted)";
    return scheduling + ", " + memory_in_words(*this) +
           (cpu >= 0 ? ", on CPU " + std::to_string(cpu) : ", on any CPU");
}

bool become_fifo() {
    sched_param priority{};
    priority.sched_priority = haptic_priority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
}

RealtimeGrant become_realtime() {
    RealtimeGrant grant;
    grant.fifo = become_fifo();
    grant.memory_limit = memory_limit();
    grant.memory = lock_memory(grant.memory_limit.has_value());
    grant.cpu = stay_on_last_cpu();
    prctl(PR_SET_TIMERSLACK, 1UL);
    return grant;
}

void sleep_until(std::chrono::steady_clock::time_point moment) {
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(moment.time_since_epoch()).count();
    const timespec when{ns / 1'000'000'000, ns % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) == EINTR) {
    }
}

}  // namespace touchable
