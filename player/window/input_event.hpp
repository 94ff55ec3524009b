#pragma once

#include <algorithm>
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

/// The time of a script, and when the window that it leads closes. A window that stood still, as on a machine
/// that was busy or asleep, goes on where it was: inputs that lie apart do not fall together.
class ScriptClock {
public:
    /// At this moment of the window's own clock, seconds; moments do not go backward. `stands`: nothing of
    /// the time since the last one counts.
    double at(double now_s, bool stands = false) {
        constexpr double longest_step_s = 0.1;  // a slow picture, but no standstill
        if (!stands) time_s_ += std::min(now_s - seen_s_, longest_step_s);
        seen_s_ = now_s;
        return time_s_;
    }

private:
    double seen_s_ = 0, time_s_ = 0;
};

}  // namespace touchable
