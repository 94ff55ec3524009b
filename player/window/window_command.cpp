#include "player/window/window_command.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/brush_words.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {
namespace {

enum class Takes { nothing, number, word, perhaps_a_word, on_or_off, size, of_tool };

struct NamedVerb {
    const char* name;
    WindowVerb verb;
    Takes takes;
    double least = 0, most = 0;  // of a number
};

constexpr double longest_s = 1e6;
constexpr NamedVerb named_verbs[] = {{"play-pause", WindowVerb::play_pause, Takes::nothing},
                                     {"seek", WindowVerb::seek_to, Takes::number, 0, longest_s},
                                     {"seek-by", WindowVerb::seek_by, Takes::number, -longest_s, longest_s},
                                     {"step", WindowVerb::step, Takes::number, -1, 1},
                                     {"speed", WindowVerb::speed, Takes::number, 0.1, 4},
                                     {"loop", WindowVerb::loop, Takes::nothing},
                                     {"next", WindowVerb::next, Takes::nothing},
                                     {"previous", WindowVerb::previous, Takes::nothing},
                                     {"fingers", WindowVerb::fingers, Takes::number, 1, 5},
                                     {"deeper", WindowVerb::deeper, Takes::number, -20, 20},
                                     {"point-right", WindowVerb::point_right, Takes::number, -10000, 10000},
                                     {"point-down", WindowVerb::point_down, Takes::number, -10000, 10000},
                                     {"force", WindowVerb::force, Takes::nothing},
                                     {"clutch", WindowVerb::clutch, Takes::on_or_off},
                                     {"recentre", WindowVerb::recentre, Takes::nothing},
                                     {"mute", WindowVerb::mute, Takes::nothing},
                                     {"volume", WindowVerb::volume, Takes::number, 0, 100},
                                     {"louder", WindowVerb::louder, Takes::number, -100, 100},
                                     {"measure", WindowVerb::measure, Takes::of_tool},
                                     {"overlay", WindowVerb::overlay, Takes::perhaps_a_word},
                                     {"dent", WindowVerb::dent, Takes::on_or_off},
                                     {"continue", WindowVerb::go_on, Takes::nothing},
                                     {"answer", WindowVerb::answer, Takes::number, 1, 11},
                                     {"home", WindowVerb::home, Takes::nothing},
                                     {"turn", WindowVerb::turn, Takes::number, -180, 180},
                                     {"tilt", WindowVerb::tilt, Takes::number, -180, 180},
                                     {"turning", WindowVerb::turning, Takes::nothing},
                                     {"nearer", WindowVerb::nearer, Takes::number, 0.1, 10},
                                     {"panel", WindowVerb::panel, Takes::nothing},
                                     {"help", WindowVerb::help, Takes::nothing},
                                     {"dismiss", WindowVerb::dismiss, Takes::nothing},
                                     {"fullscreen", WindowVerb::fullscreen, Takes::nothing},
                                     {"size", WindowVerb::size, Takes::size},
                                     {"screenshot", WindowVerb::screenshot, Takes::perhaps_a_word},
                                     {"open", WindowVerb::open, Takes::word},
                                     {"settings", WindowVerb::settings, Takes::perhaps_a_word},
                                     {"reset", WindowVerb::reset, Takes::nothing},
                                     {"tool", WindowVerb::tool, Takes::of_tool},
                                     {"material", WindowVerb::material, Takes::of_tool},
                                     {"paint", WindowVerb::paint, Takes::of_tool},
                                     {"join", WindowVerb::join, Takes::of_tool},
                                     {"cut", WindowVerb::cut, Takes::of_tool},
                                     {"otherwise", WindowVerb::otherwise, Takes::of_tool},
                                     {"undo", WindowVerb::undo, Takes::nothing},
                                     {"redo", WindowVerb::redo, Takes::nothing},
                                     {"save-materials", WindowVerb::save_materials, Takes::of_tool},
                                     {"quit", WindowVerb::quit, Takes::nothing}};

}  // namespace

std::span<const KeyGroup> key_groups() {
    using enum WindowVerb;
    static constexpr KeyBinding first_keys[] = {
        {"home", false, home, 0, "back to the clip's own view"},
        {"pageup", false, previous, 0, "the clip before, or the next one"},
        {"pagedown", false, next, 0, nullptr},
        {"<", false, previous, 0, nullptr},
        {">", false, next, 0, nullptr},
        {"t", false, measure, 0, "measure between two places, or not"}};
    static constexpr KeyBinding touch_keys[] = {
        {"1", false, fingers, 1, "so many fingers"},
        {"2", false, fingers, 2, nullptr},
        {"3", false, fingers, 3, nullptr},
        {"4", false, fingers, 4, nullptr},
        {"5", false, fingers, 5, nullptr},
        {"e", false, deeper, 0.5, "press deeper, or less"},
        {"x", false, deeper, -0.5, nullptr},
        {"w", false, point_down, -8, "move the finger"},
        {"a", false, point_right, -8, nullptr},
        {"s", false, point_down, 8, nullptr},
        {"d", false, point_right, 8, nullptr},
        {"f", false, force, 0, "force off at once, or on again"},
        {"c", false, clutch, 1, "held down: the hand moves, and no finger"},
        {"r", false, recentre, 0, "the middle is where the hand is"},
        {"j", false, coarser, 0.8, "fingers go less far with the hand, or farther"},
        {"k", false, coarser, 1.25, nullptr}};
    static constexpr KeyBinding view_keys[] = {
        {"v", false, turning, 0, "dragging turns the view, or presses again"},
        {"left", false, turn, -5, "turn the view", true},
        {"right", false, turn, 5, nullptr, true},
        {"up", false, tilt, 5, nullptr, true},
        {"down", false, tilt, -5, nullptr, true},
        {"+", false, nearer, 1.25, "nearer, or farther; so does Ctrl and the wheel"},
        {"=", false, nearer, 1.25, nullptr},
        {"-", false, nearer, 0.8, nullptr}};
    static constexpr KeyBinding play_keys[] = {
        {"space", false, play_pause, 0, "play, or pause; touch goes on"},
        {"left", false, seek_by, -1, "a second back, or on; with Shift ten"},
        {"right", false, seek_by, 1, nullptr},
        {"left", true, seek_by, -10, nullptr},
        {"right", true, seek_by, 10, nullptr},
        {",", false, step, -1, "a frame back, or on"},
        {".", false, step, 1, nullptr},
        {"[", false, faster, 0.5, "half as fast, or twice"},
        {"]", false, faster, 2, nullptr},
        {"l", false, loop, 0, "again from the beginning at the end, or not"},
        {"m", false, mute, 0, "sound off, or on again"},
        {"9", false, louder, -5, "less loud, or louder"},
        {"0", false, louder, 5, nullptr},
        {"/", false, louder, -5, nullptr},
        {"*", false, louder, 5, nullptr}};
    static constexpr KeyBinding data_keys[] = {
        {"o", false, overlay, 0, "what the surface is coloured by"},
        {"b", false, settings, 0, "the other settings of what is felt, A or B"},
        {"p", false, tool, 0, "the brush of materials, in the hand or away"},
        {"z", false, undo, 0, "undo what was painted, or redo it", true},
        {"y", false, redo, 0, nullptr, true},
        {"z", true, redo, 0, nullptr, true},
        {"s", false, save_materials, 0, "save what was painted", true}};
    static constexpr KeyBinding window_keys[] = {
        {"tab", false, panel, 0, "the panel of settings"},
        {"?", false, help, 0, "these keys, or away with them"},
        {"f1", false, help, 0, nullptr},
        {"f11", false, fullscreen, 0, "full screen, or a window; so does a double click"},
        {"f12", false, screenshot, 0, "keep a picture of the window"},
        {"backspace", true, reset, 0, "forget all settings that are kept"},
        {"escape", false, leave, 0, "close what is in front, and at last the window"},
        {"q", false, quit, 0, "close the window"}};
    using Topic = KeyGroup::Topic;
    static constexpr KeyGroup groups[] = {
        {Topic::begin, "To begin with", first_keys},    {Topic::touch, "Touch", touch_keys},
        {Topic::view, "Look around", view_keys},        {Topic::play, "Play", play_keys},
        {Topic::data, "Data and materials", data_keys}, {Topic::window, "Window and files", window_keys}};
    return groups;
}

std::span<const KeyBinding> key_bindings() {
    static const std::vector<KeyBinding> bindings = [] {
        std::vector<KeyBinding> all;
        for (const KeyGroup& group : key_groups())
            all.insert(all.end(), group.keys.begin(), group.keys.end());
        return all;
    }();
    return bindings;
}

const KeyBinding* binding_of(const std::string& key, bool control, bool shift) {
    const KeyBinding* stop = nullptr;
    for (const KeyBinding& binding : key_bindings()) {
        if (key != binding.key) continue;
        if (control == binding.control && shift == binding.shift) return &binding;
        if (binding.verb == WindowVerb::force) stop = &binding;
    }
    return stop;
}

bool goes_by_steps(WindowVerb verb) {
    switch (verb) {
        case WindowVerb::turn:
        case WindowVerb::tilt:
        case WindowVerb::seek_by:
        case WindowVerb::step:
        case WindowVerb::deeper:
        case WindowVerb::point_right:
        case WindowVerb::point_down:
        case WindowVerb::nearer:
        case WindowVerb::louder:
        case WindowVerb::undo:
        case WindowVerb::redo:
            return true;
        default:
            return false;
    }
}

bool names_window_command(const std::string& word) {
    return session_setting(word) || std::any_of(std::begin(named_verbs), std::end(named_verbs),
                                                [&](const NamedVerb& verb) { return word == verb.name; });
}

Result<WindowCommand> parse_window_command(const std::string& words) {
    const std::size_t space = std::min(words.find(' '), words.size());
    const std::string name = words.substr(0, space);
    const std::string rest = space < words.size() ? words.substr(space + 1) : "";
    const auto* const named =
        std::find_if(std::begin(named_verbs), std::end(named_verbs),
                     [&name](const NamedVerb& candidate) { return name == candidate.name; });
    if (session_setting(name)) {
        SessionSettings tried;
        TRY(tried.set(name, rest));
        return WindowCommand{WindowVerb::feel, 0, words};
    }
    if (named == std::end(named_verbs)) {
        std::string known;
        for (const NamedVerb& verb : named_verbs)
            known += (known.empty() ? "" : ", ") + std::string(verb.name);
        for (const SessionSetting& setting : session_settings()) known += ", " + std::string(setting.name);
        return usage_error("'" + name + "' is no command of the window; there are " + known);
    }
    WindowCommand command{named->verb, 0, ""};
    if (named->takes == Takes::of_tool) return read_tool_words(named->verb, name, rest);
    if (named->takes == Takes::nothing) {
        if (!rest.empty()) return usage_error("'" + name + "' takes nothing, and not '" + rest + "'");
        return command;
    }
    if (named->takes == Takes::on_or_off) {
        if (rest != "on" && rest != "off") return usage_error("'" + words + "': " + name + " is on or off");
        command.number = rest == "on" ? 1 : 0;
        return command;
    }
    if (named->takes == Takes::size) {
        const std::size_t cross = std::min(rest.find('x'), rest.size());
        const auto width = number_of(rest.substr(0, cross));
        const auto height = number_of(rest.substr(std::min(rest.size(), cross + 1)));
        command.width = static_cast<int>(std::clamp(width.value_or(0), 0.0, 1e5));
        command.height = static_cast<int>(std::clamp(height.value_or(0), 0.0, 1e5));
        const auto fits = [](int side) { return side >= 64 && side <= 8192; };
        if (!fits(command.width) || !fits(command.height))
            return usage_error("'" + words + "': size needs two numbers from 64 to 8192, such as 1280x720");
        return command;
    }
    if (named->takes != Takes::number) {
        if (named->verb == WindowVerb::settings && !rest.empty() && rest != "a" && rest != "b")
            return usage_error("'" + words +
                               "': there are settings a and b, and nothing is the other of them");
        if (named->verb == WindowVerb::overlay) TRY(overlay_after(Overlay::colour, rest));
        if (named->verb == WindowVerb::screenshot && !rest.empty() && !rest.ends_with(".png"))
            return usage_error("'" + words + "': a picture's name ends in .png");
        if (rest.empty() && named->takes == Takes::word) return usage_error("'" + name + "' needs a name");
        command.word = rest;
        return command;
    }
    const auto number = number_of(rest);
    const bool is_whole = named->verb == WindowVerb::fingers || named->verb == WindowVerb::step ||
                          named->verb == WindowVerb::answer;
    if (!number || (is_whole && *number != std::floor(*number)) || *number < named->least ||
        *number > named->most)
        return usage_error("'" + words + "': " + name + " needs a " + (is_whole ? "whole " : "") +
                           formatted("number from %g to %g", named->least, named->most));
    command.number = *number;
    return command;
}

}  // namespace touchable
