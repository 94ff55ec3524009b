// SPDX-License-Identifier: Apache-2.0
#pragma once

// The window's commands. Keys, buttons of the panel, scripts and tests all use the same WindowCommand, so
// each can do what the others can.
//
// - WindowVerb names the commands; parse_window_command reads one from words, such as "seek 10".
// - read_window_script reads a file of timed inputs and commands, for PlayOptions::script.
// - read_pixel_of_frame parses a pixel for commands of the brush; the command line uses it too.
//
//     WindowCommand later{.verb = WindowVerb::seek_to, .number = 10};
//     Result<WindowCommand> read = parse_window_command("seek 10");
//
// The table of commands (command_table.hpp) has each one's keys and handler. Refused text gives
// ErrorKind::usage, and the message says what is allowed; no message names an option of the command line.
// Threads: any; all of this is values and functions without state, but read_window_script waits for the disk.

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "engine/authoring/segments.hpp"
#include "engine/base/result.hpp"
#include "player/view/pointer.hpp"

namespace touchable {

enum class WindowVerb {
    play_pause,
    seek_by,      ///< `number`: seconds, either way
    seek_to,      ///< `number`: seconds
    step,         ///< `number`: frames, either way; pauses
    faster,       ///< `number`: factor on the speed
    speed,        ///< `number`: 0.1 to 4, times the clip's own
    loop,         ///< on or off
    next,         ///< clip of the playlist
    previous,     ///< clip of the playlist
    fingers,      ///< `number`: 1 to 5
    deeper,       ///< `number`: millimetres of the device, into the surface
    point_right,  ///< `number`: pixels to move the pointer, for users without a mouse
    point_down,   ///< `number`: pixels, downward
    force,        ///< on or off; `number` -1: off
    clutch,       ///< `number`: 1 while the haptic device is repositioned, 0 afterwards
    recentre,     ///< makes the haptic device's position the middle of its workspace
    coarser,      ///< `number`: factor on the finger's motion per device motion
    mute,         ///< sound off or on
    volume,       ///< `number`: 0 to 100, of all sound
    louder,       ///< `number`: change of the volume
    go_on,        ///< in a study: begins, or completes the screen
    answer,       ///< in a study: `number`: of the answer, from 1
    measure,      ///< `places`: two pixels; none: `word`, empty: takes the tool or puts it away, "off":
                  ///< removes the line, "here": begins one where the right button clicked
    copy,         ///< the values last shown at the pointer, to the clipboard
    overlay,      ///< `word`: the surface's colouring; empty: the next one
    light,        ///< `word`: off, soft or full (light_names); empty: the next one
    dent,         ///< `number`: 1: dents are drawn, 0: they are not
    home,         ///< the clip's own view
    undo_view,    ///< the view before the last change
    centre,       ///< of the view: the place last clicked with the right button
    turn,         ///< `number`: degrees to the right
    tilt,         ///< `number`: degrees up
    turning,      ///< dragging turns the view, or presses the finger again
    nearer,       ///< `number`: zoom factor
    panel,        ///< shown or not
    help,         ///< shown or not
    hide,         ///< all bars and words, or shows them again
    dismiss,      ///< dismisses the shown fault
    leave,        ///< the frontmost item: help, fault, brush, full screen; else the window
    fullscreen,   ///< on or off
    size,         ///< `width` x `height`: of the window, pixels
    screenshot,   ///< `word`: the file; empty: a new name in the working folder
    open,         ///< `word`: a clip
    choose,       ///< a file to open, by a dialog; `word`: of that folder, by the window's own list
    feel,         ///< `word`: a setting of touch and its value, "median 5" (session_settings.hpp)
    settings,     ///< `word`: "a" or "b", the set to put into effect; empty: the other one
    reset,        ///< all kept settings
    tool,         ///< `word`: touch, paint, join or cut; empty: away, or the last one again
    material,     ///< `word`: the material to select
    paint,        ///< `places`: a pixel of the segment to get the selected material
    join,         ///< `places`: pixels of two segments to merge
    cut,          ///< `places`: a stroke over a segment to split
    otherwise,    ///< `word`: material of all unpainted segments; empty: a guess for each
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
    std::vector<PixelOfFrame> places{};  ///< of the depth plane; frame -1: the shown one
};

/// "X,Y" or "X,Y,FRAME": a pixel's column and row up to 16383, and its frame, all from 0; the default frame
/// is -1. nullopt: the word is no pixel.
std::optional<PixelOfFrame> read_pixel_of_frame(std::string_view word);
/// Parses "seek 10", "speed 0.5", "overlay depth", "paint 120,80", or a setting of touch, "median 5".
Result<WindowCommand> parse_window_command(const std::string& words);

/// An input or command at a moment of a script.
struct ScriptedInput {
    double seconds = 0;  ///< since the first picture, by a ScriptClock
    std::variant<InputEvent, WindowCommand> what;
};

/// A file of timed inputs (docs/play.md), one a line: SECONDS, then move X Y, press BUTTON, release BUTTON,
/// wheel NOTCHES, key NAME, key-up NAME, touch N X Y, touch-move N X Y, touch-end N, leave, drop FILE, or a
/// command of the window. Times must not go backward. Errors name the line.
Result<std::vector<ScriptedInput>> read_window_script(const std::filesystem::path& file);

}  // namespace touchable
