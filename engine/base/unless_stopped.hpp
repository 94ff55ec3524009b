#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <utility>

#include "engine/base/start_thread.hpp"
#include "engine/base/stop_request.hpp"

namespace touchable {

/// Threads, of unless_stopped and others, for which nobody waits any more. As long as there is one the
/// program may not take apart what they use: it ends without (std::_Exit).
inline std::atomic<int> abandoned_threads{0};

/// What `work` returns; nothing where `is_over` says before it does that nobody waits any more, because
/// somebody asks the program to stop or, if the caller says so, for another reason. It may take as long
/// as a disk or a codec does: it is done by a thread of its own, which nobody waits for then and which comes
/// to its end alone, so `work` owns all that it uses. `stop_requested` says there that the work was given up,
/// so that it can end early. Where no thread is to be had the caller does it.
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
    const auto run_aside = [errand, goes_on = WorkAlongside::this_thread().goes_on] {
        const WorkAlongside alongside({nullptr, goes_on});
        const WorkUntil until(errand->given_up.get_token());
        errand->run();
    };
    std::thread thread;
    if (start_thread(thread, "interruptible", "that does what may take long", run_aside))
        thread.detach();
    else
        errand->run();
    std::unique_lock lock(errand->mutex);
    constexpr std::chrono::milliseconds look_again{20};  // a signal sets a flag and wakes nobody
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

}  // namespace touchable
