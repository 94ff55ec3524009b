#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "engine/base/result.hpp"
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// How strongly a gamepad's motors turn, 0 to 1: the heavy one and the light one.
struct Rumble {
    float low = 0, high = 0;
    bool operator==(const Rumble&) const = default;
};

/// What fingers feel, as a gamepad's rumble: a pure function of the ticks so far. The heavy motor is for how
/// hard a finger presses, meets the surface and lets go, the light one for slipping over rough land. Where no
/// finger has a force it is zero in that very tick.
class ContactRumble {
public:
    Rumble next(const HeardTick& tick);

private:
    double knock_ = 0, rough_ = 0;
};

/// When motors are told what. They are told for a moment only, again and again, so that they stop by
/// themselves once no more orders come.
class RumbleOrders {
public:
    static constexpr int lasts_ms = 150;         ///< an order, where no other comes
    static constexpr double renewed_s = 0.05;    ///< what goes on is ordered again after that
    static constexpr double tick_lasts_s = 0.1;  ///< without another tick nothing is felt any more

    /// At this moment of a clock that does not go backward: `rumble` of the newest of `ticks` ticks. What is
    /// to be ordered now; nothing: what was ordered goes on.
    std::optional<Rumble> at(double now_s, const Rumble& rumble, std::int64_t ticks);
    /// The gamepad that had the orders is gone, and the next one has none.
    void forget() { told_ = {}; }

private:
    Rumble told_;
    double told_s_ = 0, tick_s_ = 0;
    std::int64_t ticks_ = 0;
};

/// The gamepad whose motors turn: the first that has some, whichever is plugged in. One thread's, which also
/// opens it.
class Gamepad {
public:
    /// Errors (ErrorKind::device) are a few words; so it is where the program was built without SDL2.
    static Result<std::unique_ptr<Gamepad>> open();
    /// Stops its motors.
    virtual ~Gamepad() = default;
    /// Takes notice of what was plugged in and out; now and then, and before each order. Its name; empty:
    /// there is none.
    virtual std::string look() = 0;
    /// For so many milliseconds. Does nothing where there is none.
    virtual void rumble(const Rumble& rumble, int milliseconds) = 0;
};

/// Lets a gamepad rumble by what is felt, on a thread of its own. Motors stand still where nothing is felt,
/// where ticks stop, and from the end of this on.
class GamepadRumble {
public:
    using Open = std::function<Result<std::unique_ptr<Gamepad>>()>;

    explicit GamepadRumble(const Open& open = Gamepad::open);
    ~GamepadRumble();

    /// The next tick, from a session's thread, one session at a time. It neither waits nor allocates.
    void take(const HeardTick& tick);
    /// In a few words, for a person.
    std::string state() const;

private:
    struct Shared;
    static void run(Shared& shared, const Open& open);

    ContactRumble felt_;
    std::shared_ptr<Shared> shared_;
    std::thread thread_;
};

}  // namespace touchable
