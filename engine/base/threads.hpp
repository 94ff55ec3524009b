#pragma once

// Threads, and how work is ended.
//
// Work that takes long asks `stop_requested()` between its steps, and returns interrupted_error() once that
// is true: a person ends the program (request_stop, which a signal handler may call), or the caller of this
// thread's work gives it up. A caller that may give up one piece of work alone, such as the opening of a
// clip, holds a std::stop_source, and puts a StopScope with its token, or with a deadline, around that work.
// Nothing is handed down: each read, wait and callback below asks its thread. A thread that does a part of
// another one's work takes on that thread's StopScope.
//
// `unless_stopped` does work that may wait for a disk, a codec or a network, and leaves it behind in a thread
// of its own when the wait is given up; `wait_unless_stopped` waits for a condition, a descriptor or a
// moment. Both look every 20 ms, since a signal sets a flag and wakes no thread.
//
// start_thread begins a thread with a name, or says why there is none. RowBands shares the rows of a picture
// among a few threads that sleep in between; the bits do not depend on how many there are. A NewestValue is
// handed from one thread to another, of which neither waits. boot_ns is the clock that goes on while the
// machine is suspended.
//
// Every function may be called by any thread; a RowBands by one at a time.

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

/// Asks this program to stop. For signal handlers too.
void request_stop();

/// Whether the program is to stop, or a StopScope of this thread says that its work is given up. Work that
/// takes long looks here between its steps, and ends with an error.
bool stop_requested();

/// What work that ended for that reason returns.
Error interrupted_error();

/// Calls `work(first, last)` for 0 to `count` - 1, piece by piece, each a few milliseconds of a loop over
/// pixels. False where it was asked to stop: then the rest is left out.
bool until_stopped(std::size_t count, auto&& work) {
    constexpr std::size_t piece = std::size_t{1} << 18;
    for (std::size_t first = 0; first < count; first += piece) {
        if (stop_requested()) return false;
        work(first, std::min(count, first + piece));
    }
    return true;
}

/// What ends the work of its thread, beside a stop of the program, as long as it lives. Scopes may lie within
/// each other, and each counts.
class StopScope : NonCopyable {
public:
    using Deadline = std::chrono::steady_clock::time_point;
    static constexpr Deadline never = Deadline::max();

    /// The work may be given up.
    explicit StopScope(std::stop_token given_up) : StopScope(std::move(given_up), never, current(), false) {}
    /// It has to be done by then. Around this scope `stop_requested` tells work that was late from work that
    /// was given up.
    explicit StopScope(Deadline deadline) : StopScope({}, deadline, current(), false) {}
    /// It is a part of the work of another thread, whose `current` this is, and which waits for it.
    explicit StopScope(const StopScope* of_thread_that_waits)
        : StopScope({}, never, of_thread_that_waits, false) {}
    /// Other threads wait for it, too: the scopes around do not end it.
    static StopScope for_all();
    /// It is left to do once a person has ended a run, such as reading the frame that is to be drawn: a stop
    /// of the program does not end it. (A second request ends the program.)
    static StopScope after_stop() { return StopScope({}, never, current(), true); }
    ~StopScope();

    /// The innermost of this thread; null: there is none.
    static const StopScope* current();

private:
    friend bool stop_requested();
    StopScope(std::stop_token given_up, Deadline deadline, const StopScope* around, bool goes_on);

    const std::stop_token given_up_;
    const Deadline deadline_;
    const StopScope* const around_;  // which counts, too
    const bool goes_on_;             // whatever is asked of the program; also where one around does
    const StopScope* const before_;  // in this thread
};

/// What `work` returns under a StopScope with this token or deadline.
auto work_until(auto limit, auto&& work) {
    const StopScope until(std::move(limit));
    return work();
}

/// From one look at `stop_requested` to the next, in a wait.
inline constexpr std::chrono::milliseconds stop_look{20};

/// Waits until `is_there()` is true, which is asked every `look`. False where it was asked to stop first.
bool wait_unless_stopped(auto&& is_there, std::chrono::milliseconds look) {
    while (!is_there()) {
        if (stop_requested()) return false;
        std::this_thread::sleep_for(look);
    }
    return true;
}
/// The same of what `changed` tells. `lock` is held while `is_there` is asked, and at the end.
bool wait_unless_stopped(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                         auto&& is_there) {
    while (!changed.wait_for(lock, stop_look, is_there))
        if (stop_requested()) return false;
    return true;
}
/// Waits until poll(2) says any of `events` of a descriptor, or that it is of no use any more. False where it
/// was asked to stop first.
bool wait_unless_stopped(int descriptor, short events);
/// Waits until that moment. False where it is asked to stop before, or was when it was called.
bool wait_unless_stopped(std::chrono::steady_clock::time_point moment);

/// Starts a thread that does `work`, which throws nothing; an error where the machine has none left. `name`
/// is what debuggers, `top` and `ps` show of it, at most 15 bytes; `what` says in the error what the thread
/// is for: "that decodes".
template <std::size_t bytes, class Work>
Result<void> start_thread(std::thread& thread, const char (&name)[bytes], const char* what, Work&& work) {
    static_assert(bytes <= 16, "Linux keeps 15 bytes of a thread's name");
    try {
        thread = std::thread([name = &name[0], work = std::forward<Work>(work)]() mutable {
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

/// Threads, of unless_stopped and others, that are no longer waited for. As long as there is one the program
/// may not take apart what they use: it ends without (std::_Exit).
inline std::atomic<int> abandoned_threads{0};

/// What `work` returns; nothing where it was asked to stop first. The work may take as long as a disk or a
/// codec does: it is done by a thread of its own, which then comes to its end alone, so `work` owns all that
/// it uses. `stop_requested` says there that the work was given up, so that it can end early. Where no thread
/// is to be had the caller does it.
template <class Work>
std::optional<std::invoke_result_t<Work&>> unless_stopped(Work work) {
    struct Errand {
        Work work;
        std::mutex mutex{};
        std::condition_variable has_ended{};
        std::optional<std::invoke_result_t<Work&>> outcome{};  // guarded by mutex, as is what follows
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
        // The thread that waits hears of a stop, and hands it on.
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

/// Since the machine was started, ns: never backward, never 0, and on while it is suspended, which the steady
/// clock of Linux sleeps through.
inline std::int64_t boot_ns() {
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Rows [first, last) of a picture, and which of the threads, 0 to `threads()` - 1, is at work on them: what
/// a thread needs for itself is kept by this number.
struct RowBand {
    int first, last, thread;
};

/// As many as pay for so many pixels, if a thread more pays where it has `pixels_per_thread`: work of 50 us,
/// of which waking it takes some 5 of CPU time and a few tens of waiting. At most 4, since more of them wait
/// for memory, and others of a program want cores too; and no more than there are cores.
int threads_for(long pixels, long pixels_per_thread);

/// Threads that share the rows of a picture: the one that calls, and others that sleep in between.
class RowBands : NonCopyable {
public:
    /// `threads` with the one that calls, at least 1. The others start when first needed, and take on the
    /// scheduling of the thread that calls then, and in each call its StopScope. `until_stopped`: bands are
    /// left out once the thread that calls is asked to stop, which the caller looks for (stop_requested).
    explicit RowBands(int threads, bool until_stopped = false)
        : threads_(threads), until_stopped_(until_stopped) {
        assert(threads >= 1);
    }
    ~RowBands();

    int threads() const { return threads_; }

    /// Calls `work(RowBand)` for bands that together are rows 0 to `rows` - 1, each a multiple of `step` rows
    /// but the last; returns when all are done. What a band writes no other may read or write, and which
    /// thread has a band must not matter. What `work` throws is thrown on, the first of several, and bands
    /// that had not begun are left out. One call at a time. No allocation but where threads start.
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
        const StopScope* stop = StopScope::current();  // of the thread that calls
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

/// The newest value that one thread wrote, for one other thread to read. Neither locks, waits or retries, and
/// a value is never read half-written: of three places one is the writer's, one the reader's, and each swaps
/// its own for the one in between.
template <class T>
class NewestValue : NonCopyable {
public:
    /// Writer.
    void write(const T& value) {
        places_[writers_] = value;
        writers_ = between_.exchange(writers_ | is_new, std::memory_order_acq_rel) & ~is_new;
    }
    /// Reader. A default value before the first; what it gives stays as it is until the next call.
    const T& read() {
        if ((between_.load(std::memory_order_relaxed) & is_new) != 0)
            readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & ~is_new;
        return places_[readers_];
    }

private:
    static constexpr std::size_t is_new = 4;

    std::array<T, 3> places_{};
    alignas(64) std::size_t writers_ = 0;
    alignas(64) std::size_t readers_ = 1;
    alignas(64) std::atomic<std::size_t> between_{2};
};

}  // namespace touchable
