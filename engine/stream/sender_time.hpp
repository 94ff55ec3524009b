#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace touchable {

/// Time as a sender of streams has it; a test has its own, which passes when it wants.
class SenderTime {
public:
    virtual ~SenderTime() = default;
    /// Of std::chrono::steady_clock, ns.
    virtual std::int64_t now_ns() = 0;
    /// Since 1970 (UTC), ns: it may be stepped.
    virtual std::int64_t utc_ns() = 0;
    /// False where it was told to end before.
    virtual bool wait_until(std::int64_t at_ns) = 0;
    /// From any thread: no wait lasts any longer.
    virtual void end() = 0;
};

class SteadySenderTime final : public SenderTime {
public:
    std::int64_t now_ns() override {
        return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    }
    std::int64_t utc_ns() override {
        return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
    }
    bool wait_until(std::int64_t at_ns) override {
        const std::chrono::steady_clock::time_point at{std::chrono::nanoseconds(at_ns)};
        std::unique_lock lock(mutex_);
        return !told_.wait_until(lock, at, [this] { return is_over_; });
    }
    void end() override {
        const std::lock_guard lock(mutex_);
        is_over_ = true;
        told_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable told_;
    bool is_over_ = false;  // guarded by mutex_
};

}  // namespace touchable
