// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace touchable {

/// A user input, from a window system or a script. Positions are pixels of the picture, from its upper left.
struct InputEvent {
    enum class Kind {
        moved,     ///< the pointer, to (x, y)
        pressed,   ///< a button, `word`: left, right or middle
        released,  ///< as `pressed`
        wheel,     ///< turned by y notches, away from the person is positive
        key,  ///< `word`: a letter, digit or sign, or space, left, right, up, down, home, tab, escape, ...
        key_released,  ///< as `key`
        resized,       ///< the picture has another size, or has to be shown again
        dropped,       ///< `word`: a file or folder that was dropped on the window
        left_window,   ///< the pointer left, or the window lost the focus: nothing touches
        touch_began,   ///< a finger came down on a touch screen, at (x, y); `touch` is its number
        touch_moved,   ///< as `touch_began`
        touch_ended,   ///< it was lifted
        close          ///< a request to close the window
    };
    Kind kind = Kind::moved;
    double x = 0, y = 0;
    std::string word{};
    bool control = false, shift = false;  ///< held at that moment
    bool repeated = false;                ///< a key that is still held
    bool stopped_force = false;           ///< a key that has already switched all forces off on arrival
    std::int64_t touch = 0;               ///< unique among the fingers that are down
    double seconds = 0;                   ///< of a touch; its clock is monotonic while a finger is down
};

inline bool is_touch(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    return event.kind == Kind::touch_began || event.kind == Kind::touch_moved ||
           event.kind == Kind::touch_ended;
}

}  // namespace touchable
