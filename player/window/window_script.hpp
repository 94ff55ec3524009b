#pragma once

#include <filesystem>
#include <variant>
#include <vector>

#include "engine/base/result.hpp"
#include "player/window/input_event.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// What is done to the window at a moment of a script.
struct ScriptedInput {
    double seconds = 0;  ///< since the first picture, by a ScriptClock
    std::variant<InputEvent, WindowCommand> what;
};

/// The time of a script, and when the window that it leads closes. A window that stood still, as on a machine
/// that was busy or asleep, goes on where it was: inputs that lie apart do not fall together.
class ScriptClock {
public:
    /// At this moment of the window's own clock, seconds; moments do not go backward. `stands`: nothing of
    /// the time since the last one counts.
    double at(double now_s, bool stands = false);

private:
    double seen_s_ = 0, time_s_ = 0;
};

/// A file of timed inputs (docs/play-options.md), a line each: SECONDS, then move X Y, press BUTTON, release
/// BUTTON, wheel NOTCHES, key NAME, key-up NAME, touch N X Y, touch-move N X Y, touch-end N, leave, drop
/// FILE, or a command of the window. Times must not go backward. Refused with the line.
Result<std::vector<ScriptedInput>> read_window_script(const std::filesystem::path& file);

}  // namespace touchable
