#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/authoring/segment_names.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// What keys, buttons of the panel, scripts and tests ask of the window: one set for all of them.
enum class WindowVerb {
    play_pause,
    seek_by,      ///< `number`: seconds, either way
    seek_to,      ///< `number`: seconds
    step,         ///< `number`: frames, either way; pauses
    faster,       ///< `number`: times as fast as now
    speed,        ///< `number`: 0.1 to 4, times the clip's own
    loop,         ///< on or off
    next,         ///< clip of the playlist
    previous,     ///< likewise
    fingers,      ///< `number`: 1 to 5
    deeper,       ///< `number`: millimetres of the device, pressed in by
    point_right,  ///< `number`: pixels by which the pointer moves, for whoever has keys alone
    point_down,   ///< likewise
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
    otherwise,   ///< `word`: material of all segments that nobody painted; empty: a guess for each
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

/// A key and what it does.
struct KeyBinding {
    const char* key;  ///< as InputEvent names it
    bool shift;
    WindowVerb verb;
    double number;
    const char* what;  ///< for a person; null: the same as the row above
    bool control = false;
};
/// Keys that belong together: what a list of them has under one title. The first are those that somebody
/// new needs.
struct KeyGroup {
    enum class Topic { begin, touch, view, play, data, window };
    Topic topic;
    const char* title;
    std::span<const KeyBinding> keys;
};
/// All keys, in the order of the list.
std::span<const KeyGroup> key_groups();
/// Likewise, without titles.
std::span<const KeyBinding> key_bindings();
/// Keys of a study, beside key_bindings(), that a script may press.
inline constexpr const char* study_keys[] = {"enter", "6", "7", "8"};
/// Of a key with what is held; null: it does nothing. The key that takes the force off does so whatever is
/// held.
const KeyBinding* binding_of(const std::string& key, bool control, bool shift);

/// Whether a key that is held does it again and again: what goes on by steps, never what switches.
bool goes_by_steps(WindowVerb verb);

/// Whether it is the first word of a command.
bool names_window_command(const std::string& word);
/// "seek 10", "speed 0.5", "overlay depth" and so on. Refused (ErrorKind::usage) with what would be right.
Result<WindowCommand> parse_window_command(const std::string& words);

}  // namespace touchable
