#pragma once

// What a window can be asked to do. Keys, buttons of the panel, scripts and tests all ask by the same
// WindowCommand, so that each can do what the others can.
//
// - WindowVerb names the commands; parse_window_command reads one from words, such as "seek 10".
// - read_window_script reads a file of timed inputs and commands, for PlayOptions::script.
// - read_pixel_of_frame reads a pixel as commands of the brush name it; the command line reads it so, too.
//
//     WindowCommand later{.verb = WindowVerb::seek_to, .number = 10};
//     Result<WindowCommand> read = parse_window_command("seek 10");
//
// The table of commands (command_table.hpp) has the key of each, and what carries it out. All of this is
// values and functions without state, for any thread; read_window_script waits for the disk. Refused words
// are ErrorKind::usage, and the message says what would be right; no message names an option of the command
// line.

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "engine/authoring/segments.hpp"
#include "engine/base/result.hpp"
#include "player/window/input_event.hpp"

namespace touchable {

enum class WindowVerb {
    play_pause,
    seek_by,      ///< `number`: seconds, either way
    seek_to,      ///< `number`: seconds
    step,         ///< `number`: frames, either way; pauses
    faster,       ///< `number`: times as fast as now
    speed,        ///< `number`: 0.1 to 4, times the clip's own
    loop,         ///< on or off
    next,         ///< clip of the playlist
    previous,     ///< clip of the playlist
    fingers,      ///< `number`: 1 to 5
    deeper,       ///< `number`: millimetres of the device, pressed in by
    point_right,  ///< `number`: pixels by which the pointer moves, for a person without a mouse
    point_down,   ///< `number`: pixels, downward
    force,        ///< on or off; `number` -1: off
    clutch,       ///< `number`: 1 while a held device is repositioned, 0 afterwards
    recentre,     ///< the place where a held device is now becomes the middle of its workspace
    coarser,      ///< `number`: factor on how far a finger goes when a held device moves
    mute,         ///< no sound, or again
    volume,       ///< `number`: 0 to 100, of all that is heard
    louder,       ///< `number`: by which the volume grows
    go_on,        ///< in a study: the participant begins, or has done with the screen
    answer,       ///< in a study: `number`: of the answers that are there, from 1
    measure,     ///< `places`: two pixels; none: `word`, empty: the tool, in the hand or away, "off": no line
    overlay,     ///< `word`: what the surface is coloured by; empty: the next one
    dent,        ///< `number`: 1 where a surface that gives way is drawn so, 0 where it is not
    home,        ///< the clip's own view
    turn,        ///< `number`: degrees to the right
    tilt,        ///< `number`: degrees up
    turning,     ///< dragging turns the view, or presses the finger again
    nearer,      ///< `number`: factor by which the view comes nearer
    panel,       ///< shown or not
    help,        ///< shown or not
    dismiss,     ///< the fault that is shown was read
    leave,       ///< what is in front: help, fault, brush, full screen; where nothing is, the window
    fullscreen,  ///< on or off
    size,        ///< `width` x `height`: of the window, pixels
    screenshot,  ///< `word`: the file; empty: a new name in the working folder
    open,        ///< `word`: a clip
    feel,        ///< `word`: a setting of what is felt and its value, "median 5" (session_settings.hpp)
    settings,    ///< `word`: "a" or "b", the set of settings that is in effect; empty: the other one
    reset,       ///< everything that is kept from one window to the next
    tool,        ///< `word`: touch, paint, join or cut; empty: away, or the last one again
    material,    ///< `word`: the material in hand
    paint,       ///< `places`: a pixel of the segment that gets the material in hand
    join,        ///< `places`: pixels of two segments that are one from now on
    cut,         ///< `places`: a stroke over a segment that is two from now on
    otherwise,   ///< `word`: material of all segments that are not painted; empty: a guess for each
    undo,
    redo,
    save_materials,  ///< `word`: the file; empty: the clip's own
    quit
};

struct WindowCommand {
    WindowVerb verb = WindowVerb::play_pause;
    double number = 0;
    std::string word{};
    int width = 0, height = 0;
    std::vector<PixelOfFrame> places{};  ///< of the depth plane; frame -1: the one that is shown
};

/// "X,Y" or "X,Y,FRAME": a pixel's column and row up to 16383, and its frame, all from 0; without a frame it
/// is -1. Nothing: the word is no pixel.
std::optional<PixelOfFrame> read_pixel_of_frame(std::string_view word);
/// "seek 10", "speed 0.5", "overlay depth", "paint 120,80", or a setting of what is felt, "median 5".
Result<WindowCommand> parse_window_command(const std::string& words);

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
    double at(double now_s, bool stands = false) {
        constexpr double longest_step_s = 0.1;  // a slow picture, but no standstill
        if (!stands) time_s_ += std::min(now_s - seen_s_, longest_step_s);
        seen_s_ = now_s;
        return time_s_;
    }

private:
    double seen_s_ = 0, time_s_ = 0;
};

/// A file of timed inputs (docs/play.md), a line each: SECONDS, then move X Y, press BUTTON, release
/// BUTTON, wheel NOTCHES, key NAME, key-up NAME, touch N X Y, touch-move N X Y, touch-end N, leave, drop
/// FILE, or a command of the window. Times must not go backward. Refused with the line.
Result<std::vector<ScriptedInput>> read_window_script(const std::filesystem::path& file);

}  // namespace touchable
