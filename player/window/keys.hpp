#pragma once

// The keys of a window. key_groups has them in the order of the help page, each with its WindowCommand's verb
// and number; binding_of finds the command of a key that was pressed. A key that is not here does nothing,
// but for those of a study (study.hpp). The tables do not change, and any thread may read them.

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>

#include "player/window/window_command.hpp"

namespace touchable {

/// Whether a verb is in a list.
inline bool is_one_of(WindowVerb verb, std::initializer_list<WindowVerb> verbs) {
    return std::find(verbs.begin(), verbs.end(), verb) != verbs.end();
}

/// A key and what it does.
struct KeyBinding {
    const char* key;  ///< as InputEvent names it
    bool shift;
    WindowVerb verb;
    double number;
    const char* what;  ///< for a person; null: the same as the row above
    bool control = false;
};
/// Keys that belong together, under one title of the help page. The first group has what a beginner needs.
struct KeyGroup {
    enum class Topic { begin, touch, view, play, data, window };
    Topic topic;
    const char* title;
    std::span<const KeyBinding> keys;
};
/// All keys, in the order of the list.
std::span<const KeyGroup> key_groups();
/// The same keys, without titles.
std::span<const KeyBinding> key_bindings();
/// The binding of a key with Ctrl and Shift; null: it does nothing. The key that takes the force off does so
/// with any of them held.
const KeyBinding* binding_of(const std::string& key, bool control, bool shift);
/// Whether a key that is held does it again and again: what goes on by steps, never what switches.
bool goes_by_steps(WindowVerb verb);

}  // namespace touchable
