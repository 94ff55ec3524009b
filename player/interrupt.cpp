#include "player/interrupt.hpp"

#include <atomic>
#include <csignal>

namespace touchable {
namespace {

std::atomic<bool> asked_to_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing that locks");

}  // namespace

void catch_interrupts() {
    struct sigaction action = {};
    action.sa_handler = [](int) { asked_to_stop.store(true, std::memory_order_relaxed); };
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGHUP, &action, nullptr);  // the terminal is gone
    std::signal(SIGXFSZ, SIG_IGN);  // a file at its allowed size is an error of that write, told as any other
}

bool interrupted() {
    return asked_to_stop.load(std::memory_order_relaxed);
}

Error interrupted_error() {
    return {ErrorKind::internal, "interrupted; nothing half-written is left"};
}

}  // namespace touchable
