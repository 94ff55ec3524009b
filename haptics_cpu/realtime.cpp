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
    return scheduling + (memory_locked ? ", memory locked" : ", memory not locked (not permitted)");
}

RealtimeGrant become_realtime() {
    RealtimeGrant grant;
    sched_param priority{};
    priority.sched_priority = haptic_priority;
    grant.fifo = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
    grant.memory_locked = mlockall(MCL_CURRENT) == 0;
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
