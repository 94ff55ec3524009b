#pragma once

// The table of all commands of a window: a row for each has its name in scripts, what it takes, its keys,
// what the help says of them, what is right where words are refused, who may give it, and what carries it
// out. To add a command is to add a WindowVerb and a row here; scripts, keys, the help page, kiosk and study
// go by it.
//
//     row_of(WindowVerb::seek_by).handler(core, {WindowVerb::seek_by, 10});
//
// key_bindings has the keys in the order of the help page; binding_of finds the command of a key that was
// pressed. A key that is not here does nothing, but for those of a study (study_mode.cpp). The table does not
// change, and any thread may read it; handlers are the window thread's.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "player/window/window_command.hpp"

namespace touchable {

class WindowCore;

/// One command.
struct CommandRow {
    /// The part of the help page. The first has what a beginner needs.
    enum class Topic { begin, touch, view, play, data, window };
    enum class Words { nothing, number, whole_number, on_or_off, width_and_height, word, places };
    struct Takes {
        Words words = Words::nothing;
        double least = 0, most = 0;  ///< of a number
    };
    enum Rule : unsigned {
        without_clip = 1,       ///< it does something as long as there is no clip, too
        by_steps = 2,           ///< a key that is held does it again and again: it switches nothing
        for_visitors = 4,       ///< of a kiosk
        for_participants = 12,  ///< of a study, while they touch; for visitors, too
        of_pointer = 16,        ///< it leads the pointer's fingers
        of_hand = 32,           ///< it is of a device that is held
        alternates = 64         ///< its keys take turns with those of the row above
    };
    struct Key {
        const char* key;  ///< as InputEvent names it
        double number = 0;
        bool control = false, shift = false;
    };
    /// Carries the command out, where `rules` allow it.
    using Handler = void (*)(WindowCore& window, const WindowCommand& command);

    WindowVerb verb;
    const char* name;  ///< in scripts; null: it is given by keys and buttons alone
    Topic topic;
    Takes takes;
    unsigned rules;  ///< Rule
    std::vector<Key> keys;
    const char* help;  ///< of its keys, for a person; null: that of the row above
    Handler handler;
    const char* hint;  ///< what is right, where its words are refused

    bool has(Rule rule) const { return (rules & rule) == rule; }
};

std::span<const CommandRow> command_rows();
const CommandRow& row_of(WindowVerb verb);
/// Null: no script has a command of that name.
const CommandRow* command_named(std::string_view name);

/// A key and what it does.
struct KeyBinding {
    const char* key;  ///< as InputEvent names it
    bool shift;
    WindowVerb verb;
    double number;
    const char* what;  ///< for a person; null: the same as the key above
    bool control;
    CommandRow::Topic topic;
};
/// All keys, in the order of the table.
std::span<const KeyBinding> key_bindings();
/// The binding of a key with Ctrl and Shift; null: it does nothing. The key that takes the force off does so
/// with any of them held.
const KeyBinding* binding_of(const std::string& key, bool control, bool shift);
/// Whether a key that is held does it again and again.
bool goes_by_steps(WindowVerb verb);

}  // namespace touchable
