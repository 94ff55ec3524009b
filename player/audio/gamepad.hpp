#pragma once

#include <memory>
#include <string>

#include "engine/base/result.hpp"
#include "player/audio/contact_rumble.hpp"

namespace touchable {

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

}  // namespace touchable
