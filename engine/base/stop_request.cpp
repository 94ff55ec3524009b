#include "engine/base/stop_request.hpp"

#include <atomic>
#include <utility>

namespace touchable {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing that locks");

thread_local bool goes_on = false;
thread_local const WorkUntil* innermost = nullptr;

}  // namespace

void request_stop() {
    requested.store(true, std::memory_order_relaxed);
}

bool stop_requested() {
    if (requested.load(std::memory_order_relaxed) && !goes_on) return true;
    for (const WorkUntil* work = innermost; work != nullptr; work = work->around_)
        if (work->given_up_.stop_requested()) return true;
    return false;
}

WorkUntil::WorkUntil(std::stop_token given_up)
    : given_up_(std::move(given_up)), around_(std::exchange(innermost, this)) {}

WorkUntil::~WorkUntil() {
    innermost = around_;
}

WorkForAll::WorkForAll() : around_(std::exchange(innermost, nullptr)) {}

WorkForAll::~WorkForAll() {
    innermost = around_;
}

WorkAlongside::Whom WorkAlongside::this_thread() {
    return {innermost, goes_on};
}

WorkAlongside::WorkAlongside(const Whom& whom) : before_(this_thread()) {
    innermost = whom.until;
    goes_on = whom.goes_on;
}

WorkAlongside::~WorkAlongside() {
    innermost = before_.until;
    goes_on = before_.goes_on;
}

Error interrupted_error() {
    return {ErrorKind::interrupted, "interrupted; nothing half-written is left"};
}

WorkAfterStop::WorkAfterStop() : before_(std::exchange(goes_on, true)) {}

WorkAfterStop::~WorkAfterStop() {
    goes_on = before_;
}

}  // namespace touchable
