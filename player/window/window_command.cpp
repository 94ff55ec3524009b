// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_command.hpp"

#include <sstream>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/brush.hpp"
#include "player/window/command_table.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {
namespace {

using Words = CommandRow::Words;

constexpr int most_column = 16383;
constexpr std::int64_t most_frame = 999'999'999;

std::optional<std::int64_t> whole_number(std::string_view word, std::int64_t most) {
    const auto value = parsed_as<std::int64_t>(word);
    return value && *value >= 0 && *value <= most ? value : std::nullopt;
}

/// Whether the text has the pixels that the command takes, and no more.
bool read_places(const std::string& rest, WindowCommand& command) {
    const bool is_cut = command.verb == WindowVerb::cut;
    const std::size_t least = command.verb == WindowVerb::paint ? 1 : 2,
                      most = is_cut ? HeldBrush::most_points : least;
    std::istringstream words(rest);
    for (std::string word; words >> word;) {
        const auto place = read_pixel_of_frame(word);
        if (!place || command.places.size() == most) return false;
        if (command.verb == WindowVerb::measure && place->frame >= 0)
            return false;  // it measures what is shown
        if (is_cut && !command.places.empty() && place->frame != command.places[0].frame) return false;
        command.places.push_back(*place);
    }
    return command.places.size() >= least;
}

bool read_size(const std::string& rest, WindowCommand& command) {
    const std::size_t cross = std::min(rest.find('x'), rest.size());
    const auto side = [](const std::string& word) {
        return static_cast<int>(std::clamp(parsed_number(word).value_or(0), 0.0, 1e5));
    };
    command.width = side(rest.substr(0, cross));
    command.height = side(rest.substr(std::min(rest.size(), cross + 1)));
    return std::min(command.width, command.height) >= 64 && std::max(command.width, command.height) <= 8192;
}

/// Whether the command takes this text. An error already says what is allowed.
Result<bool> read_words(const std::string& rest, WindowCommand& command) {
    command.word = rest;
    switch (command.verb) {
        case WindowVerb::open:
            return !rest.empty();
        case WindowVerb::settings:
            return rest.empty() || rest == "a" || rest == "b";
        case WindowVerb::screenshot:
            return rest.empty() || rest.ends_with(".png");
        case WindowVerb::save_materials:
            return rest.empty() || rest.ends_with(".json");
        case WindowVerb::tool:
            return rest.empty() || brush_tool_of(rest);
        case WindowVerb::overlay:
            TRY(overlay_after(Overlay::colour, rest));
            return true;
        case WindowVerb::light:
            TRY(light_after(Lighting::off, rest));
            return true;
        case WindowVerb::material:
            return find_material(rest) ? Result<bool>(true)
                                       : usage_error("material: " + no_such_material(rest));
        case WindowVerb::otherwise:
            if (rest == "guess") command.word.clear();
            return rest == "guess" || find_material(rest)
                       ? Result<bool>(true)
                       : usage_error("otherwise: " + no_such_material(rest) + ", or guess");
        default:
            return true;
    }
}

/// Whether the command takes the text after its name.
Result<bool> read_rest(const CommandRow& row, const std::string& rest, WindowCommand& command) {
    const auto number = parsed_number(rest);
    switch (row.takes.words) {
        case Words::nothing:
            return rest.empty();
        case Words::on_or_off:
            command.number = rest == "on" ? 1 : 0;
            return rest == "on" || rest == "off";
        case Words::number:
        case Words::whole_number:
            command.number = number.value_or(0);
            return number && *number >= row.takes.least && *number <= row.takes.most &&
                   (row.takes.words == Words::number || *number == std::floor(*number));
        case Words::width_and_height:
            return read_size(rest, command);
        case Words::places:
            return read_places(rest, command);
        default:
            if (row.verb == WindowVerb::measure && !rest.empty() && rest != "off")
                return read_places(rest, command);
            return read_words(rest, command);
    }
}

std::string right_words(const CommandRow& row) {
    if (row.hint) return row.hint;
    switch (row.takes.words) {
        case Words::nothing:
            return "nothing else";
        case Words::on_or_off:
            return "on or off";
        case Words::width_and_height:
            return "two numbers from 64 to 8192, such as 1280x720";
        default:
            return (row.takes.words == Words::number ? "a number " : "a whole number ") +
                   formatted("from %g to %g", row.takes.least, row.takes.most);
    }
}

bool ends(std::istringstream& words) {
    std::string more;
    return !(words >> more);
}

/// Keys of a study or a list, besides key_bindings(), that a script may press.
constexpr const char* other_keys[] = {"enter", "up", "down", "6", "7", "8"};
constexpr std::int64_t most_scripted = 10;  // fingers on a touch screen; `inputs` names it

/// Fails if no key of that name does anything.
Result<void> check_key(const std::string& name) {
    std::string known;
    for (const KeyBinding& binding : key_bindings()) {
        if (binding.shift || binding.control) continue;  // a script holds neither
        if (name == binding.key) return {};
        known += std::string(known.empty() ? "" : " ") + binding.key;
    }
    for (const char* const key : other_keys) {
        if (name == key) return {};
        known += std::string(" ") + key;
    }
    return usage_error("unknown key '" + name + "'; must be one of " + known);
}

/// Inputs of a script, as messages list them; `right`: what follows the name.
constexpr struct {
    const char* name;
    InputEvent::Kind kind;
    const char* right;
} inputs[] = {{"move", InputEvent::Kind::moved, "two numbers, pixels from the upper left"},
              {"press", InputEvent::Kind::pressed, "left, right or middle"},
              {"release", InputEvent::Kind::released, "left, right or middle"},
              {"wheel", InputEvent::Kind::wheel, "a number of notches"},
              {"key", InputEvent::Kind::key, "the name of one key"},
              {"key-up", InputEvent::Kind::key_released, "the name of one key"},
              {"touch", InputEvent::Kind::touch_began,
               "the number of a finger, from 1 to 10, and two numbers, pixels from the upper left"},
              {"touch-move", InputEvent::Kind::touch_moved,
               "the number of a finger, from 1 to 10, and two numbers, pixels from the upper left"},
              {"touch-end", InputEvent::Kind::touch_ended, "the number of a finger, from 1 to 10"},
              {"leave", InputEvent::Kind::left_window, "nothing else"},
              {"drop", InputEvent::Kind::dropped, "a file or folder"}};

/// Parses inputs such as "move 10 20"; nullopt if it is no input.
Result<std::optional<InputEvent>> read_input(const std::string& line) {
    using Kind = InputEvent::Kind;
    std::istringstream words(line);
    std::string name;
    words >> name;
    const auto* const input = std::ranges::find(inputs, name, [](const auto& one) { return one.name; });
    if (input == std::end(inputs)) return std::optional<InputEvent>();
    InputEvent event{.kind = input->kind};
    const bool is_key = event.kind == Kind::key || event.kind == Kind::key_released,
               is_button = event.kind == Kind::pressed || event.kind == Kind::released;
    bool fits = true;
    if (is_touch(event)) {
        words >> event.touch;
        fits = event.touch >= 1 && event.touch <= most_scripted;
    }
    if (event.kind == Kind::moved || (is_touch(event) && event.kind != Kind::touch_ended))
        words >> event.x >> event.y;
    if (event.kind == Kind::wheel) words >> event.y;
    if (is_key || is_button) words >> event.word;
    if (is_button) fits = event.word == "left" || event.word == "right" || event.word == "middle";
    if (event.kind == Kind::dropped) std::getline(words >> std::ws, event.word);
    if (!words || !fits || !ends(words)) return usage_error(name + " needs " + input->right);
    if (is_key) TRY(check_key(event.word));
    return std::optional(event);
}

Result<ScriptedInput> read_line(const std::string& line) {
    std::istringstream words(line);
    ScriptedInput input;
    std::string rest;
    if (!(words >> input.seconds) || !(input.seconds >= 0) || !(input.seconds <= 1e6))
        return usage_error("must begin with a time from 0 to 1e6, in seconds");
    std::getline(words >> std::ws, rest);
    TRY_ASSIGN(auto event, read_input(rest));
    if (event) {
        event->seconds = input.seconds;
        input.what = std::move(*event);
        return input;
    }
    auto command = parse_window_command(rest);
    const std::string name = rest.substr(0, rest.find(' '));
    if (!command && (session_setting(name) || command_named(name))) return command.error();
    if (!command)
        return usage_error(command.error().message + "; or an input: " + listed(inputs, [](const auto& one) {
                               return std::string(one.name);
                           }));
    input.what = std::move(*command);
    return input;
}

}  // namespace

std::optional<PixelOfFrame> read_pixel_of_frame(std::string_view word) {
    const std::size_t first = word.find(',');
    if (first == std::string_view::npos) return std::nullopt;
    const std::size_t second = word.find(',', first + 1);
    const bool has_frame = second != std::string_view::npos;
    const auto x = whole_number(word.substr(0, first), most_column);
    const auto y = whole_number(word.substr(first + 1, has_frame ? second - first - 1 : second), most_column);
    const auto frame =
        has_frame ? whole_number(word.substr(second + 1), most_frame) : std::optional<std::int64_t>(-1);
    if (!x || !y || !frame) return std::nullopt;
    return PixelOfFrame{static_cast<int>(*x), static_cast<int>(*y), *frame};
}

Result<WindowCommand> parse_window_command(const std::string& words) {
    const std::size_t space = std::min(words.find(' '), words.size());
    const std::string name = words.substr(0, space);
    const std::string rest = space < words.size() ? words.substr(space + 1) : "";
    if (session_setting(name)) {
        TRY(SessionSettings().set(name, rest));
        return WindowCommand{.verb = WindowVerb::feel, .word = words};
    }
    const CommandRow* const row = command_named(name);
    if (!row) {
        std::vector<std::string> known;
        for (const CommandRow& any : command_rows())
            if (any.name) known.emplace_back(any.name);
        return usage_error("unknown command '" + name + "'; must be one of " + listed(known) + ", " +
                           listed(session_settings(), &SessionSetting::name));
    }
    WindowCommand command{.verb = row->verb};
    TRY_ASSIGN(const bool fits, read_rest(*row, rest, command));
    if (!fits) return usage_error("'" + words + "': " + name + " needs " + right_words(*row));
    return command;
}

Result<std::vector<ScriptedInput>> read_window_script(const std::filesystem::path& file) {
    constexpr std::size_t largest = std::size_t{16} << 20;
    auto text =
        read_given_file(file, "script " + file.string(), "a file of timed inputs (docs/play.md)", largest);
    const auto refuse = [](Error error) {
        error.hints = {{Setting::script}};
        return error;
    };
    if (!text) return refuse(text.error());
    std::istringstream in(std::move(*text));
    std::vector<ScriptedInput> inputs;
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string::npos || line[first] == '#') continue;
        const std::string where = "script " + file.string() + ", line " + std::to_string(number);
        while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
        auto input = read_line(line);
        if (!input) return refuse(input_error(where + ": " + input.error().message));
        if (!inputs.empty() && input->seconds < inputs.back().seconds)
            return refuse(input_error(where + ": its time is before that of the line above"));
        inputs.push_back(std::move(*input));
    }
    return inputs;
}

}  // namespace touchable
