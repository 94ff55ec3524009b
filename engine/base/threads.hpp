#pragma once

// Threads, and how work is ended.
//
// start_thread begins a thread with a name, or says why there is none. RowBands shares the rows of a picture
// among a few threads that sleep in between; the bits do not depend on how many there are. A NewestValue is
// handed from one thread to another, of which neither waits. A person ends the
// program by request_stop (a signal handler may call it). Work that takes long asks stop_requested between
// its steps and returns interrupted_error; what may wait for a disk, a codec or a network is handed to
// unless_stopped, which leaves it to a thread of its own once the program is to end. A caller that may give
// up one piece of work alone, such as the opening of a clip, holds a std::stop_source and puts a WorkUntil
// around that work: stop_requested then says so to its thread. A StopScope puts a part of a thread's work
// under other rules, such as those of the thread that it works for. boot_ns is the clock that goes on while
// the machine is suspended.
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

/// Whether the program is to stop, or what this thread works for was given up (WorkUntil). Work that takes
/// long looks here between its steps, and gives up with an error.
bool stop_requested();

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

/// What work that stopped for that reason returns.
Error interrupted_error();

/// As long as it lives, its thread does work that its caller may give up, such as the opening of a clip: once
/// that happens, `stop_requested` says so to this thread, and with it every read and every wait. Scopes may
/// lie within each other, and each counts.
class WorkUntil {
public:
    explicit WorkUntil(std::stop_token given_up);
    ~WorkUntil();
    WorkUntil(const WorkUntil&) = delete;
    WorkUntil& operator=(const WorkUntil&) = delete;

private:
    friend bool stop_requested();
    const std::stop_token given_up_;
    const WorkUntil* const around_;
};

/// As long as it lives, its thread stops by other rules than before.
class StopScope {
public:
    /// What `stop_requested` goes by in a thread.
    struct Rules {
        const WorkUntil* until = nullptr;
        bool goes_on = false;
    };
    /// Those of this thread. Another one that does a part of its work meanwhile takes them on, as long as
    /// this one waits for it.
    static Rules current();
    /// For work that other threads wait for, too: giving up what this thread works for does not end it.
    static Rules for_all() { return {nullptr, current().goes_on}; }
    /// For what is left to do once a person has ended a run, such as reading the frame that is to be drawn:
    /// this thread goes on. (A second wish to stop ends the program.)
    static Rules after_stop() { return {current().until, true}; }

    explicit StopScope(const Rules& rules);
    ~StopScope();
    StopScope(const StopScope&) = delete;
    StopScope& operator=(const StopScope&) = delete;

private:
    const Rules before_;
};

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

/// What `work` returns; nothing where `is_over` says first that the wait is over, because the program is
/// asked to stop or, if the caller says so, for another reason. The work may take as long as a disk or a
/// codec does: it is done by a thread of its own, which then comes to its end alone, so `work` owns all that
/// it uses. `stop_requested` says there that the work was given up, so that it can end early. Where no thread
/// is to be had the caller does it.
template <class Work, class IsOver = bool (*)()>
std::optional<std::invoke_result_t<Work&>> unless_stopped(Work work, IsOver is_over = stop_requested) {
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
    const auto run_aside = [errand, rules = StopScope::for_all()] {
        const StopScope scope(rules);
        const WorkUntil until(errand->given_up.get_token());
        errand->run();
    };
    std::thread thread;
    if (start_thread(thread, "interruptible", "that does what may take long", run_aside))
        thread.detach();
    else
        errand->run();
    std::unique_lock lock(errand->mutex);
    constexpr std::chrono::milliseconds look_again{20};  // a signal sets a flag and wakes no thread
    while (!errand->has_ended.wait_for(lock, look_again, [&] { return errand->over; }))
        if (is_over()) {
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
class RowBands {
public:
    /// `threads` with the one that calls, at least 1. The others start when first needed, and take on the
    /// scheduling of the thread that calls then. `until_stopped`: bands are left out once the thread that
    /// calls is asked to stop, which the caller looks for (stop_requested).
    explicit RowBands(int threads, bool until_stopped = false);
    ~RowBands();
    RowBands(const RowBands&) = delete;
    RowBands& operator=(const RowBands&) = delete;

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
class NewestValue {
public:
    NewestValue() = default;
    NewestValue(const NewestValue&) = delete;
    NewestValue& operator=(const NewestValue&) = delete;

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
