#include "player/run/interrupt.hpp"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <ctime>

#include "engine/base/stop_request.hpp"

namespace touchable {
namespace {

std::atomic<std::int64_t> first_ns{0};  // when the first one came
static_assert(std::atomic<std::int64_t>::is_always_lock_free,
              "a signal handler may touch nothing that locks");

std::int64_t now_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// A person who asks again does so later. What comes at once is the same wish: a terminal and whoever watches
/// the program may both send it, and ending now would leave half-written what is just being cleared away.
void take_signal(int signal) {
    const int error_before = errno;
    const std::int64_t now = now_ns();
    std::int64_t first = 0;
    if (first_ns.compare_exchange_strong(first, now)) {
        request_stop();
    } else if (now - first >= std::int64_t{1'000'000} * same_wish.count()) {
        std::signal(signal, SIG_DFL);
        raise(signal);
    }
    errno = error_before;
}

/// A signal that whoever started the program ignores stays ignored: nohup, a shell's background.
void catch_signal(int signal) {
    struct sigaction inherited = {};
    sigaction(signal, nullptr, &inherited);
    if (inherited.sa_handler == SIG_IGN) return;
    struct sigaction action = {};
    action.sa_handler = take_signal;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
}

}  // namespace

void catch_interrupts() {
    catch_signal(SIGINT);
    catch_signal(SIGTERM);
    catch_signal(SIGHUP);           // the terminal is gone
    std::signal(SIGXFSZ, SIG_IGN);  // a file at its allowed size is an error of that write, told as any other
}

bool interrupted() {
    return stop_requested();
}

void ignore_stop_keys() {
    for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(signal, SIG_IGN);
}

}  // namespace touchable
