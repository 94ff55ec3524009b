#pragma once

#include <string>

namespace touchable {

/// Something a person did, whatever window system or script tells it. Positions are pixels of the picture,
/// from its upper left.
struct InputEvent {
    enum class Kind {
        moved,     ///< the pointer, to (x, y)
        pressed,   ///< a button, `word`: left, right or middle
        released,  ///< likewise
        wheel,     ///< turned by y notches, away from the person is positive
        key,  ///< `word`: a letter, digit or sign, or space, left, right, up, down, home, tab, escape, ...
        key_released,  ///< likewise
        resized,       ///< the picture is now x by y pixels
        dropped,       ///< `word`: a file or folder that was dropped on the window
        left_window,   ///< the pointer is nowhere, or the window is no longer looked at
        close          ///< the window is to be closed
    };
    Kind kind = Kind::moved;
    double x = 0, y = 0;
    std::string word{};
    bool control = false, shift = false;  ///< held at that moment
    bool repeated = false;                ///< a key that is still held
};

}  // namespace touchable
