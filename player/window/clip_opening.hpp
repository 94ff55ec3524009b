#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "engine/result.hpp"
#include "engine/start_thread.hpp"

namespace touchable {

/// What takes long to make ready for the window, on a thread of its own: a clip, or other settings of one.
/// One at a time, and of those that are asked for meanwhile the newest. All calls are the window's.
template <class Made>
class ClipOpening {
public:
    /// Looks at the token between its steps, and gives up once it was asked to stop.
    using Make = std::function<Result<Made>(const std::stop_token&)>;

    ClipOpening() = default;
    ClipOpening(const ClipOpening&) = delete;
    ClipOpening& operator=(const ClipOpening&) = delete;
    ~ClipOpening() { give_up(); }

    /// `words`: what is being done, for a person. What was asked for before is given up.
    void ask(std::string words, Make make) {
        next_.emplace(Asked{std::move(words), std::move(make)});
        if (work_)
            work_->stop.request_stop();
        else
            start_next();
    }
    /// Nothing is on its way any more. Waits until that looks at its token.
    void give_up() {
        next_.reset();
        if (!work_) return;
        work_->stop.request_stop();
        if (work_->thread.joinable()) work_->thread.join();
        work_.reset();
    }
    bool is_busy() const { return work_ != nullptr; }
    /// Of what is wanted; empty where nothing is.
    std::string words() const {
        if (next_) return next_->words;
        return work_ ? work_->words : std::string();
    }
    /// Since it was begun.
    double seconds() const {
        if (!work_) return 0;
        return std::chrono::duration<double>(Clock::now() - work_->begun).count();
    }
    /// Once a turn of the window: what was asked for, or why it is not to be had; nothing while it is made.
    std::optional<Result<Made>> take() {
        if (!work_ || !work_->done.load(std::memory_order_acquire)) return std::nullopt;
        if (work_->thread.joinable()) work_->thread.join();
        const std::unique_ptr<Work> work = std::move(work_);
        if (next_) {
            start_next();
            return std::nullopt;
        }
        return std::move(work->made);
    }

private:
    using Clock = std::chrono::steady_clock;
    struct Asked {
        std::string words;
        Make make;
    };
    struct Work {
        std::string words;
        Make make;
        Clock::time_point begun = Clock::now();
        std::stop_source stop{};
        std::optional<Result<Made>> made{};  // the thread's, until it is done
        std::atomic<bool> done{false};
        std::thread thread{};
    };

    void start_next() {
        work_ = std::make_unique<Work>();
        work_->words = std::move(next_->words);
        work_->make = std::move(next_->make);
        next_.reset();
        const auto started =
            start_thread(work_->thread, "clip-opening", "that opens clips", [work = work_.get()] {
                work->made = made_by(*work);
                work->done.store(true, std::memory_order_release);
            });
        if (started.ok()) return;
        work_->made = started.error();
        work_->done.store(true, std::memory_order_release);
    }
    /// Nothing thrown leaves the thread.
    static Result<Made> made_by(Work& work) {
        try {
            return work.make(work.stop.get_token());
        } catch (const std::bad_alloc&) {
            return input_error(work.words + ": memory does not suffice");
        } catch (const std::exception& fault) {
            return Error{ErrorKind::internal, work.words + ": " + fault.what()};
        }
    }

    std::unique_ptr<Work> work_;
    std::optional<Asked> next_;
};

}  // namespace touchable
