#include "engine/stop_request.hpp"

#include <atomic>

namespace touchable {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing that locks");

}  // namespace

void request_stop() {
    requested.store(true, std::memory_order_relaxed);
}

bool stop_requested() {
    return requested.load(std::memory_order_relaxed);
}

}  // namespace touchable
