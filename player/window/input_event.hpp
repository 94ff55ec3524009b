#pragma once

#include <cstdint>
#include <string>

namespace touchable {

/// Something that a person did, told by a window system or by a script. Positions are pixels of the picture,
/// from its upper left.
struct InputEvent {
    enum class Kind {
        moved,     ///< the pointer, to (x, y)
        pressed,   ///< a button, `word`: left, right or middle
        released,  ///< as `pressed`
        wheel,     ///< turned by y notches, away from the person is positive
        key,  ///< `word`: a letter, digit or sign, or space, left, right, up, down, home, tab, escape, ...
        key_released,  ///< as `key`
        resized,       ///< the picture is now x by y pixels
        dropped,       ///< `word`: a file or folder that was dropped on the window
        left_window,   ///< the pointer is nowhere, or the window is no longer looked at: nothing touches
        touch_began,   ///< a finger came down on a touch screen, at (x, y); `touch` is its number
        touch_moved,   ///< as `touch_began`
        touch_ended,   ///< it was lifted
        close          ///< the window is to be closed
    };
    Kind kind = Kind::moved;
    double x = 0, y = 0;
    std::string word{};
    bool control = false, shift = false;  ///< held at that moment
    bool repeated = false;                ///< a key that is still held
    bool stopped_force = false;           ///< a key that has taken all forces off as it arrived
    std::int64_t touch = 0;               ///< no two fingers that are down have the same
    double seconds = 0;  ///< of a touch: when, by a clock that does not go backward while a finger is down
};

inline bool is_touch(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    return event.kind == Kind::touch_began || event.kind == Kind::touch_moved ||
           event.kind == Kind::touch_ended;
}

}  // namespace touchable
