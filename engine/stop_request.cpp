#include "engine/stop_request.hpp"

#include <atomic>
#include <utility>

namespace touchable {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing that locks");

thread_local bool goes_on = false;

}  // namespace

void request_stop() {
    requested.store(true, std::memory_order_relaxed);
}

bool stop_requested() {
    return requested.load(std::memory_order_relaxed) && !goes_on;
}

Error interrupted_error() {
    return {ErrorKind::interrupted, "interrupted; nothing half-written is left"};
}

WorkAfterStop::WorkAfterStop() : before_(std::exchange(goes_on, true)) {}

WorkAfterStop::~WorkAfterStop() {
    goes_on = before_;
}

}  // namespace touchable
