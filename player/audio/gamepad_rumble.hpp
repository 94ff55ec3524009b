#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "player/audio/contact_rumble.hpp"
#include "player/audio/gamepad.hpp"

namespace touchable {

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
