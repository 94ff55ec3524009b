#include "haptics_cpu/realtime.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#include <cerrno>

namespace touchable {

std::string RealtimeGrant::in_words() const {
    const std::string scheduling = fifo ? "SCHED_FIFO" : "normal scheduling (SCHED_FIFO is not permitted)";
    return scheduling + (memory_locked ? ", memory locked" : ", memory not locked (not permitted)") +
           (cpu >= 0 ? ", on CPU " + std::to_string(cpu) : ", on any CPU");
}

namespace {

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

RealtimeGrant become_realtime() {
    RealtimeGrant grant;
    sched_param priority{};
    priority.sched_priority = haptic_priority;
    grant.fifo = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
    grant.memory_locked = mlockall(MCL_CURRENT) == 0;
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
