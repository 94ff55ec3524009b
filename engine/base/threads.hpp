// SPDX-License-Identifier: Apache-2.0
#pragma once

// Threads, and the cancellation of long work.
//
// Long work checks `stop_requested()` between its steps, and returns interrupted_error() once it is true: a
// person ends the program (request_stop, which a signal handler may call), or the caller of this thread's
// work cancels it. A caller that may cancel one piece of work alone, such as the opening of a clip, holds a
// std::stop_source, and puts a StopScope with its token, or with a deadline, around that work. No argument is
// passed down: each read, wait and callback below checks the scopes of its thread. A thread that does a part
// of another thread's work takes on that thread's StopScope.
//
// `unless_stopped` runs work that may wait for a disk, a codec or a network in a thread of its own, and
// leaves it behind when the wait is cancelled; `wait_unless_stopped` waits for a condition, a descriptor or a
// moment. Both check every 20 ms, since a signal sets a flag and wakes no thread.
//
// start_thread starts a named thread, or says why it cannot. RowBands shares the rows of a picture among a
// few threads that sleep between calls; the bits do not depend on their number. boot_ns is a clock that runs
// on while the machine is suspended.
//
// Threads: any may call every function; one at a time a RowBands.

#include <pthread.h>
#include <time.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <stop_token>
#include <system_error>
#include <thread>
#include <type_traits>

#include "engine/base/result.hpp"

namespace touchable {

/// Asks this program to stop; safe in signal handlers.
void request_stop();

/// Returns true if the program is to stop, or a StopScope of this thread is cancelled. Long work checks this
/// between its steps, and then ends with an error.
bool stop_requested();

/// The error that cancelled work returns.
Error interrupted_error();

/// Calls `work(first, last)` for 0 to `count` - 1, piece by piece, each a few milliseconds of a loop over
/// pixels. Returns false, and skips the rest, if a stop is requested.
bool until_stopped(std::size_t count, auto&& work) {
    constexpr std::size_t piece = std::size_t{1} << 18;
    for (std::size_t first = 0; first < count; first += piece) {
        if (stop_requested()) return false;
        work(first, std::min(count, first + piece));
    }
    return true;
}

/// Cancels the work of its thread, in addition to a stop of the program, as long as the scope lives. Scopes
/// may be nested, and each counts.
class StopScope : NonCopyable {
public:
    using Deadline = std::chrono::steady_clock::time_point;
    static constexpr Deadline never = Deadline::max();

    /// Cancelled by this token.
    explicit StopScope(std::stop_token given_up) : StopScope(std::move(given_up), never, current(), false) {}
    /// Cancelled after this deadline. Outside this scope `stop_requested` tells work that was late from work
    /// that was cancelled.
    explicit StopScope(Deadline deadline) : StopScope({}, deadline, current(), false) {}
    /// For a part of the work of another thread, which waits for it and whose `current` this is.
    explicit StopScope(const StopScope* of_thread_that_waits)
        : StopScope({}, never, of_thread_that_waits, false) {}
    /// For work that other threads wait for, too: the outer scopes do not cancel it.
    static StopScope for_all();
    /// For work that remains after a person has ended a run, such as reading the frame that is to be drawn: a
    /// stop of the program does not cancel it. (A second request ends the program.)
    static StopScope after_stop() { return StopScope({}, never, current(), true); }
    ~StopScope();

    /// Returns the innermost scope of this thread; null: none.
    static const StopScope* current();

private:
    friend bool stop_requested();
    StopScope(std::stop_token given_up, Deadline deadline, const StopScope* around, bool goes_on);

    const std::stop_token given_up_;
    const Deadline deadline_;
    const StopScope* const around_;  // the outer scope, which counts, too
    const bool goes_on_;             // ignores a stop of the program; inherited from `around`
    const StopScope* const before_;  // the previous scope of this thread
};

/// Returns the result of `work`, run under a StopScope with this token or deadline.
auto work_until(auto limit, auto&& work) {
    const StopScope until(std::move(limit));
    return work();
}

/// The time between two checks of `stop_requested` in a wait.
inline constexpr std::chrono::milliseconds stop_look{20};

/// Waits until `is_there()` is true, checking every `look`. Returns false if a stop is requested first.
bool wait_unless_stopped(auto&& is_there, std::chrono::milliseconds look) {
    while (!is_there()) {
        if (stop_requested()) return false;
        std::this_thread::sleep_for(look);
    }
    return true;
}
/// The same for a condition that `changed` signals. `lock` is held while `is_there` runs, and at the end.
bool wait_unless_stopped(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                         auto&& is_there) {
    while (!changed.wait_for(lock, stop_look, is_there))
        if (stop_requested()) return false;
    return true;
}
/// Waits until poll(2) reports any of `events`, an error or a hang-up. Returns false if a stop is requested
/// first.
bool wait_unless_stopped(int descriptor, short events);
/// Waits until that moment. Returns false if a stop is requested before, or was before the call.
bool wait_unless_stopped(std::chrono::steady_clock::time_point moment);

/// Starts a thread that runs `work`, which must not throw; an error if the machine has no thread left. `name`
/// is what debuggers, `top` and `ps` show, at most 15 bytes; `what` says in the error what the thread is for:
/// "that decodes".
template <std::size_t bytes>
Result<void> start_thread(std::thread& thread, const char (&name)[bytes], const char* what, auto work) {
    static_assert(bytes <= 16, "Linux keeps 15 bytes of a thread's name");
    try {
        thread = std::thread([name = &name[0], work = std::move(work)]() mutable {
            pthread_setname_np(pthread_self(), name);
            work();
        });
    } catch (const std::system_error& refused) {
        return Error{ErrorKind::internal,
                     std::string("the thread ") + what + " cannot be started (" + refused.code().message() +
                         "); is there memory for it, and room below the limit of threads?"};
    }
    return {};
}

/// Sets `stopping`, for which `thread` waits by `mutex` and `changed`, and waits for its end, if it was
/// started.
inline void stop_thread(std::mutex& mutex, bool& stopping, std::condition_variable& changed,
                        std::thread& thread) {
    {
        const std::lock_guard lock(mutex);
        stopping = true;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
}

/// The number of threads, of unless_stopped and others, that are no longer waited for. While it is not 0, the
/// program must not destroy what they use: it ends by std::_Exit.
inline std::atomic<int> abandoned_threads{0};

/// Returns the result of `work`; nullopt if a stop is requested first. The work may take as long as a disk or
/// a codec does: it runs in a thread of its own, which after a stop ends alone, so `work` owns all that it
/// uses. `stop_requested` is true there once the work is cancelled, so that it can end early. If no thread
/// can be started, the caller's thread runs it.
template <class Work>
std::optional<std::invoke_result_t<Work&>> unless_stopped(Work work) {
    struct Errand {
        Work work;
        std::mutex mutex{};
        std::condition_variable has_ended{};
        std::optional<std::invoke_result_t<Work&>> outcome{};  // guarded by mutex, like the members below
        std::exception_ptr fault{};
        bool over = false, is_abandoned = false;
        std::stop_source given_up{};

        void run() {
            std::optional<std::invoke_result_t<Work&>> made;
            std::exception_ptr thrown;
            try {
                made.emplace(work());
            } catch (...) {
                thrown = std::current_exception();
            }
            const std::lock_guard lock(mutex);
            outcome = std::move(made);
            fault = std::move(thrown);
            over = true;
            if (is_abandoned) --abandoned_threads;
            has_ended.notify_one();
        }
    };
    const auto errand = std::shared_ptr<Errand>(new Errand{std::move(work)});
    const auto run_aside = [errand] {
        // The waiting thread notices a stop, and passes it on.
        const StopScope goes_on = StopScope::after_stop();
        const StopScope until(errand->given_up.get_token());
        errand->run();
    };
    std::thread thread;
    if (start_thread(thread, "interruptible", "that does what may take long", run_aside))
        thread.detach();
    else
        errand->run();
    std::unique_lock lock(errand->mutex);
    if (!wait_unless_stopped(errand->has_ended, lock, [&] { return errand->over; })) {
        errand->is_abandoned = true;
        ++abandoned_threads;
        errand->given_up.request_stop();
        return std::nullopt;
    }
    if (errand->fault) std::rethrow_exception(errand->fault);
    return std::move(errand->outcome);
}

/// The time of one of the system's clocks, such as CLOCK_PROCESS_CPUTIME_ID, in nanoseconds.
inline std::int64_t clock_ns(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Nanoseconds since the machine was started: never backward, never 0, and running on while it is suspended,
/// unlike the steady clock of Linux.
inline std::int64_t boot_ns() {
    return clock_ns(CLOCK_BOOTTIME);
}

/// Rows [first, last) of a picture, and the number, 0 to `threads()` - 1, of the thread that works on them,
/// which is the index of that thread's own data.
struct RowBand {
    int first, last, thread;
};

/// Returns the number of threads that pays for `pixels`, if one more pays for `pixels_per_thread`: work of 50
/// us, of which waking a thread takes some 5 us of CPU time and a few tens of waiting. At most `most`,
/// by default 4, since more threads wait for memory, and other threads need cores, too; and at most the
/// number of cores.
int threads_for(long pixels, long pixels_per_thread, int most = 4);

/// Threads that share the rows of a picture: the caller's, and others that sleep between calls.
class RowBands : NonCopyable {
public:
    /// `threads`: with the caller's, at least 1. The others start when first needed, and take on the
    /// scheduling of the thread that calls then, and in each call its StopScope. `until_stopped`: bands are
    /// left out once the caller's thread is asked to stop, which the caller checks (stop_requested).
    explicit RowBands(int threads, bool until_stopped = false)
        : threads_(threads), until_stopped_(until_stopped) {
        assert(threads >= 1);
    }
    ~RowBands();

    int threads() const { return threads_; }

    /// Calls `work(RowBand)` for bands that together are rows 0 to `rows` - 1, each a multiple of `step` rows
    /// except the last; returns when all are done. No band may read or write what another writes, and the
    /// result must not depend on which thread has a band. The first exception of `work` is rethrown, and
    /// bands that had not begun are left out. One call at a time. Allocates only when threads start.
    template <class Work>
    void for_each_band(int rows, int step, Work&& work) {
        using Plain = std::remove_reference_t<Work>;
        run({rows, step, [](void* call, const RowBand& band) { (*static_cast<Plain*>(call))(band); }, &work});
    }

private:
    struct Job {
        int rows = 0, step = 1;
        void (*call)(void* work, const RowBand& band) = nullptr;
        void* work = nullptr;
        int band_rows = 0, next_row = 0, bands_at_work = 0;
        const StopScope* stop = StopScope::current();  // of the caller's thread
    };
    void run(Job job);
    void start_others();
    void work_on(std::unique_lock<std::mutex>& lock, const RowBand& band);
    void take_bands(std::unique_lock<std::mutex>& lock, int thread);
    void serve(int thread);

    const int threads_;
    const bool until_stopped_;
    std::mutex mutex_;
    std::condition_variable there_is_work_, all_done_;
    Job job_;
    std::exception_ptr fault_;
    bool ending_ = false;
    std::vector<std::thread> others_;
};

}  // namespace touchable
