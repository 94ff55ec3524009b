// SPDX-License-Identifier: Apache-2.0
#include "engine/base/threads.hpp"

#include <poll.h>

namespace touchable {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing that locks");

thread_local const StopScope* innermost = nullptr;

/// More bands than threads, so that a thread that is late, or whose core is taken, does not hold up the
/// others for long; and short bands, so that their first rows are still in the cache when the last are done.
constexpr int bands_per_thread = 4, most_rows = 128;

}  // namespace

void request_stop() {
    requested.store(true, std::memory_order_relaxed);
}

bool stop_requested() {
    if (requested.load(std::memory_order_relaxed) && !(innermost && innermost->goes_on_)) return true;
    for (const StopScope* scope = innermost; scope != nullptr; scope = scope->around_) {
        const bool is_late =
            scope->deadline_ != StopScope::never && std::chrono::steady_clock::now() > scope->deadline_;
        if (is_late || scope->given_up_.stop_requested()) return true;
    }
    return false;
}

const StopScope* StopScope::current() {
    return innermost;
}

StopScope StopScope::for_all() {
    return StopScope({}, never, nullptr, innermost && innermost->goes_on_);
}

StopScope::StopScope(std::stop_token given_up, Deadline deadline, const StopScope* around, bool goes_on)
    : given_up_(std::move(given_up)),
      deadline_(deadline),
      around_(around),
      goes_on_(goes_on || (around && around->goes_on_)),
      before_(std::exchange(innermost, this)) {}

StopScope::~StopScope() {
    innermost = before_;
}

bool wait_unless_stopped(int descriptor, short events) {
    const auto is_ready = [descriptor, events] {
        pollfd waited{descriptor, events, 0};
        return ::poll(&waited, 1, static_cast<int>(stop_look.count())) > 0;
    };
    return wait_unless_stopped(is_ready, std::chrono::milliseconds(0));
}

bool wait_unless_stopped(std::chrono::steady_clock::time_point moment) {
    while (!stop_requested()) {
        const auto now = std::chrono::steady_clock::now();
        if (now >= moment) return true;
        std::this_thread::sleep_until(std::min(moment, now + stop_look));
    }
    return false;
}

Error interrupted_error() {
    return {ErrorKind::interrupted, "interrupted; nothing half-written is left"};
}

int threads_for(long pixels, long pixels_per_thread, int most) {
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    return std::clamp(static_cast<int>(std::min<long>(pixels / pixels_per_thread, most)), 1,
                      std::max(cores, 1));
}

RowBands::~RowBands() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    there_is_work_.notify_all();
    for (std::thread& other : others_) other.join();
}

void RowBands::run(Job job) {
    const int steps = (job.rows + job.step - 1) / job.step;
    job.band_rows =
        job.step * std::clamp(steps / (threads_ * bands_per_thread), 1, std::max(most_rows / job.step, 1));
    if (threads_ == 1 || job.rows <= job.step) {
        for (int y = 0; y < job.rows && !(until_stopped_ && stop_requested()); y += job.band_rows)
            job.call(job.work, {y, std::min(y + job.band_rows, job.rows), 0});
        return;
    }
    std::unique_lock lock(mutex_);
    start_others();
    job_ = job;
    there_is_work_.notify_all();
    take_bands(lock, 0);
    all_done_.wait(lock, [this] { return job_.bands_at_work == 0; });
    if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
}

/// If the system grants no more threads, those that exist do all the work.
void RowBands::start_others() {
    while (static_cast<int>(others_.size()) < threads_ - 1) {
        const int thread = static_cast<int>(others_.size()) + 1;
        others_.emplace_back();
        if (start_thread(others_.back(), "row-bands", "that shares rows", [this, thread] { serve(thread); }))
            continue;
        others_.pop_back();
        return;
    }
}

void RowBands::work_on(std::unique_lock<std::mutex>& lock, const RowBand& band) {
    const Job job = job_;
    lock.unlock();
    std::exception_ptr fault;
    try {
        const StopScope alongside(job.stop);
        job.call(job.work, band);
    } catch (...) {
        fault = std::current_exception();
    }
    lock.lock();
    if (!fault) return;
    if (!fault_) fault_ = fault;
    job_.next_row = job_.rows;
}

/// Works on bands until none is left. `lock` is released only while a band is worked on.
void RowBands::take_bands(std::unique_lock<std::mutex>& lock, int thread) {
    while (job_.next_row < job_.rows) {
        const RowBand band{job_.next_row, std::min(job_.next_row + job_.band_rows, job_.rows), thread};
        job_.next_row = band.last;
        ++job_.bands_at_work;
        work_on(lock, band);
        if (until_stopped_ && thread == 0 && stop_requested()) job_.next_row = job_.rows;
        if (--job_.bands_at_work == 0) all_done_.notify_one();
    }
}

void RowBands::serve(int thread) {
    std::unique_lock lock(mutex_);
    while (true) {
        there_is_work_.wait(lock, [this] { return ending_ || job_.next_row < job_.rows; });
        if (ending_) return;
        take_bands(lock, thread);
    }
}

}  // namespace touchable
