// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <iterator>
#include <new>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "player/window/window_clock.hpp"

namespace touchable {

/// Slow work for the window on a separate thread: opening a clip, changing settings, reading segments. One at
/// a time; of several requests meanwhile only the newest counts. The window's thread only.
template <class Made>
class LongWork : NonCopyable {
public:
    /// Checks stop_requested between its steps, and returns once it is true.
    using Make = std::function<Result<Made>()>;

    /// As in start_thread: the thread's name and purpose.
    template <std::size_t bytes>
    LongWork(const char (&name)[bytes], const char* what) : what_(what) {
        static_assert(bytes <= sizeof(ThreadName));
        std::copy(std::begin(name), std::end(name), std::begin(name_));
    }
    ~LongWork() { give_up(); }

    /// `words`: the work, for the user. Cancels the previous work.
    void ask(std::string words, Make make) {
        next_.reset(new Work{std::move(words), std::move(make)});
        if (work_)
            work_->stop.request_stop();
        else
            start_next();
    }
    /// Cancels all work without waiting: the current work ends once it checks for the stop, and the next
    /// request begins then.
    void let_go() {
        next_.reset();
        if (!work_) return;
        work_->stop.request_stop();
        work_->is_wanted = false;
    }
    /// Cancels all work, and waits until it has ended.
    void give_up() {
        let_go();
        if (work_ && work_->thread.joinable()) work_->thread.join();
        work_.reset();
    }
    /// Whether wanted work is pending or in progress.
    bool is_busy() const { return next_ || (work_ && work_->is_wanted); }
    /// Of the wanted work; empty if there is none.
    std::string words() const {
        if (next_) return next_->words;
        return is_busy() ? work_->words : std::string();
    }
    /// Since the work began.
    double seconds() const {
        if (!is_busy() || !work_) return 0;
        return Clock::seconds_between(work_->begun, Clock::now());
    }
    /// Once a turn of the window: the result or error; nullopt while in progress.
    std::optional<Result<Made>> take() {
        if (!work_ || !work_->done.load(std::memory_order_acquire)) return std::nullopt;
        if (work_->thread.joinable()) work_->thread.join();
        // Destroys this work before the next begins, which may need its resources.
        const bool is_wanted = work_->is_wanted && !next_;
        std::optional<Result<Made>> made;
        if (is_wanted) made = std::move(work_->made);
        work_.reset();
        if (next_) start_next();
        return made;
    }

private:
    using Clock = WindowClock;
    struct Work {
        std::string words;
        Make make;
        Clock::time_point begun{};
        std::stop_source stop{};
        bool is_wanted = true;
        std::optional<Result<Made>> made{};  // the thread's, until it is done
        std::atomic<bool> done{false};
        std::thread thread{};
    };

    void start_next() {
        work_ = std::move(next_);
        work_->begun = Clock::now();
        const auto started = start_thread(work_->thread, name_, what_, [work = work_.get()] {
            work->made = made_by(*work);
            work->done.store(true, std::memory_order_release);
        });
        if (started) return;
        work_->made = started.error();
        work_->done.store(true, std::memory_order_release);
    }
    /// Catches exceptions: none may leave the thread.
    static Result<Made> made_by(Work& work) {
        try {
            return work_until(work.stop.get_token(), work.make);
        } catch (const std::bad_alloc&) {
            return input_error(work.words + ": memory does not suffice");
        } catch (const std::exception& fault) {
            return internal_error(work.words + ": " + fault.what());
        }
    }

    using ThreadName = char[16];
    ThreadName name_{};
    const char* what_;
    std::unique_ptr<Work> work_, next_;  // next_: the newest request, until its thread begins
};

}  // namespace touchable
