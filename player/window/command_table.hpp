// SPDX-License-Identifier: Apache-2.0
#pragma once

// The table of all commands of a window: a row has the command's name in scripts, its arguments, its keys,
// their help text, the hint if its arguments are refused, the permissions, and the handler. To add a command,
// add a WindowVerb and a row here; scripts, keys, the help page, kiosk and study use the table.
//
//     row_of(WindowVerb::seek_by).handler(core, {WindowVerb::seek_by, 10});
//
// key_bindings lists the keys in the order of the help page; binding_of finds the command of a pressed key.
// Other keys do nothing, except a study's (study_mode.cpp). The table is constant, and any thread may read
// it; handlers run on the window's thread.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "player/window/window_command.hpp"

namespace touchable {

class WindowCore;

/// One command.
struct CommandRow {
    /// The section of the help page. The first is for beginners.
    enum class Topic { begin, touch, view, play, data, window };
    enum class Words { nothing, number, whole_number, on_or_off, width_and_height, word, places };
    struct Takes {
        Words words = Words::nothing;
        double least = 0, most = 0;  ///< of a number
    };
    enum Rule : unsigned {
        without_clip = 1,       ///< allowed without a clip
        by_steps = 2,           ///< a held key repeats it; not for switches
        for_visitors = 4,       ///< allowed in a kiosk
        for_participants = 12,  ///< allowed in a study's touch; includes visitors
        of_pointer = 16,        ///< moves the pointer's fingers
        of_hand = 32,           ///< needs a haptic device
        alternates = 64         ///< its keys alternate with those of the row above
    };
    struct Key {
        const char* key;  ///< as InputEvent names it
        double number = 0;
        bool control = false, shift = false;
    };
    /// Executes the command, if `rules` allow it.
    using Handler = void (*)(WindowCore& window, const WindowCommand& command);

    WindowVerb verb;
    const char* name;  ///< in scripts; null: keys and buttons only
    Topic topic;
    Takes takes;
    unsigned rules;  ///< Rule
    std::vector<Key> keys;
    const char* help;  ///< of its keys, for the user; null: that of the row above
    Handler handler;
    const char* hint;  ///< allowed arguments, if the given ones are refused

    bool has(Rule rule) const { return (rules & rule) == rule; }
};

std::span<const CommandRow> command_rows();
const CommandRow& row_of(WindowVerb verb);
/// Null if no command has that name in scripts.
const CommandRow* command_named(std::string_view name);

/// A key and its command.
struct KeyBinding {
    const char* key;  ///< as InputEvent names it
    bool shift;
    WindowVerb verb;
    double number;
    const char* what;  ///< for the user; null: the same as the key above
    bool control;
    CommandRow::Topic topic;
};
/// All keys, in the order of the table.
std::span<const KeyBinding> key_bindings();
/// The binding of a key with Ctrl and Shift; null: none. The key that switches the force off works with
/// either of them held.
const KeyBinding* binding_of(const std::string& key, bool control, bool shift);

}  // namespace touchable
