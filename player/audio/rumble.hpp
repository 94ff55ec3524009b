#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// Schedules orders to motors. Orders are short and repeated, so that motors stop by themselves without
/// further orders.
class RumbleOrders {
public:
    static constexpr int lasts_ms = 150;         ///< duration of an order
    static constexpr double renewed_s = 0.05;    ///< interval of repeated orders
    static constexpr double tick_lasts_s = 0.1;  ///< after that without a new tick, rumble is zero

    /// Call with a monotonic time, the newest tick's `rumble`, and the number of ticks so far. Returns the
    /// order to give; nullopt: the last one continues.
    std::optional<Rumble> at(double now_s, const Rumble& rumble, std::int64_t ticks);
    /// The gamepad has changed, and the new one has no order.
    void forget() { told_ = {}; }

private:
    Rumble told_;
    double told_s_ = 0, tick_s_ = 0;
    std::int64_t ticks_ = 0;
};

/// The gamepad that rumbles: the first one with motors, whichever is plugged in. One thread's, which also
/// opens it.
class Gamepad {
public:
    /// Errors (ErrorKind::device) are a few words; one is that the program was built without SDL2.
    static Result<std::unique_ptr<Gamepad>> open();
    /// Stops its motors.
    virtual ~Gamepad() = default;
    /// Detects plugging in and out; call regularly, and before each order. Returns its name; empty: none.
    virtual std::string look() = 0;
    /// Rumbles for that time. Does nothing without a gamepad.
    virtual void rumble(const Rumble& rumble, int milliseconds) = 0;
};

/// Makes a gamepad rumble with contacts, on a separate thread. Motors stop without contact, if ticks stop,
/// and when this is destroyed.
class GamepadRumble : NonCopyable {
public:
    using Open = std::function<Result<std::unique_ptr<Gamepad>>()>;

    explicit GamepadRumble(const Open& open = Gamepad::open);
    ~GamepadRumble() { stop_thread(mutex_, stopping_, stop_, thread_); }

    /// Takes the next tick on a session's thread, one session at a time. Neither waits nor allocates.
    void consume(const HeardTick& tick);
    /// In a few words, for the user.
    std::string state() const;

private:
    void say(std::string words);
    bool goes_on();
    void run(const Open& open);

    ContactRumble felt_;
    std::atomic<Rumble> newest_{};
    static_assert(std::atomic<Rumble>::is_always_lock_free, "a session's thread does not wait");
    std::atomic<std::int64_t> ticks_{0};
    mutable std::mutex mutex_;
    std::condition_variable stop_;
    bool stopping_ = false;
    std::string state_ = "rumble: looking for a gamepad";
    std::thread thread_;
};

}  // namespace touchable
