#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "player/run/output_file.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// What a run writes of every tick. A disk that is full, or gone, ends the file and not the run: nothing more
/// is taken. A reader of standard output that lags behind a live run, or a person who asks to stop while one
/// is waited for, ends the run.
class OutputSink : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) final {
        if (is_faulty_) return {};
        auto kept = write(tick);
        if (kept.ok()) return kept;
        is_faulty_ = true;
        if (kept.error().kind == ErrorKind::interrupted || file_->reader_lags()) return kept;
        spoil(kept.error());
        return {};
    }
    /// Why it takes no more ticks; any thread.
    std::optional<Error> fault() const {
        const std::lock_guard lock(mutex_);
        return fault_;
    }
    std::string name() const { return file_->name(); }  ///< as OutputFile has it

protected:
    explicit OutputSink(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}
    virtual Result<void> write(const TouchTick& tick) = 0;
    bool is_faulty() const { return is_faulty_; }
    /// Nothing more is taken. By the thread that takes, or after it.
    void spoil(const Error& why) {
        is_faulty_ = true;
        const std::lock_guard lock(mutex_);
        if (!fault_) fault_ = why;
    }

    const std::unique_ptr<OutputFile> file_;

private:
    bool is_faulty_ = false;  // the thread's that takes
    mutable std::mutex mutex_;
    std::optional<Error> fault_;  // guarded by it
};

}  // namespace touchable
