#include "player/window/window_script.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "engine/base/given_file.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

bool ends(std::istringstream& words) {
    std::string more;
    return !(words >> more);
}

constexpr std::int64_t most_scripted = 10;

/// "move 10 20" and the like; nothing where it is none of the inputs.
Result<std::optional<InputEvent>> read_input(const std::string& line) {
    using Kind = InputEvent::Kind;
    std::istringstream words(line);
    std::string name;
    words >> name;
    InputEvent event;
    if (name == "move") {
        if (!(words >> event.x >> event.y) || !ends(words))
            return usage_error("move needs two numbers, pixels from the upper left");
        return std::optional(event);
    }
    if (name == "wheel") {
        event.kind = Kind::wheel;
        if (!(words >> event.y) || !ends(words)) return usage_error("wheel needs a number of notches");
        return std::optional(event);
    }
    if (name == "press" || name == "release") {
        event.kind = name == "press" ? Kind::pressed : Kind::released;
        words >> event.word;
        const bool known = event.word == "left" || event.word == "right" || event.word == "middle";
        if (!known || !ends(words)) return usage_error(name + " needs left, right or middle");
        return std::optional(event);
    }
    if (name == "key" || name == "key-up") {
        event.kind = name == "key" ? Kind::key : Kind::key_released;
        if (!(words >> event.word) || !ends(words)) return usage_error(name + " needs the name of one key");
        std::string known;
        for (const KeyBinding& binding : key_bindings()) {
            if (binding.shift || binding.control) continue;  // a script holds neither
            if (event.word == binding.key) return std::optional(event);
            known += std::string(known.empty() ? "" : " ") + binding.key;
        }
        for (const char* const key : study_keys) {
            if (event.word == key) return std::optional(event);
            known += std::string(" ") + key;
        }
        return usage_error("no key " + event.word + " does anything; there are " + known);
    }
    if (name == "touch" || name == "touch-move" || name == "touch-end") {
        const bool has_place = name != "touch-end";
        event.kind = name == "touch" ? Kind::touch_began : has_place ? Kind::touch_moved : Kind::touch_ended;
        const bool is_read = (words >> event.touch) && (!has_place || (words >> event.x >> event.y));
        if (!is_read || event.touch < 1 || event.touch > most_scripted || !ends(words))
            return usage_error(name + " needs the number of a finger, from 1 to " +
                               std::to_string(most_scripted) +
                               (has_place ? ", and two numbers, pixels from the upper left" : ""));
        return std::optional(event);
    }
    if (name == "leave") {
        event.kind = Kind::left_window;
        if (!ends(words)) return usage_error("leave stands alone");
        return std::optional(event);
    }
    if (name == "drop") {
        event.kind = Kind::dropped;
        std::getline(words >> std::ws, event.word);
        if (event.word.empty()) return usage_error("drop needs a file or folder");
        return std::optional(event);
    }
    return std::optional<InputEvent>();
}

Result<ScriptedInput> read_line(const std::string& line) {
    std::istringstream words(line);
    ScriptedInput input;
    std::string rest;
    if (!(words >> input.seconds) || !(input.seconds >= 0) || !(input.seconds <= 1e6))
        return usage_error("must begin with a time from 0 to 1e6, in seconds");
    std::getline(words >> std::ws, rest);
    TRY_ASSIGN(const auto event, read_input(rest));
    if (event) {
        InputEvent known = *event;
        known.seconds = input.seconds;
        input.what = std::move(known);
        return input;
    }
    auto command = parse_window_command(rest);
    if (!command.ok() && names_window_command(rest.substr(0, rest.find(' ')))) return command.error();
    if (!command.ok())
        return usage_error(command.error().message +
                           "; or an input: move, press, release, wheel, key, key-up, touch, touch-move, "
                           "touch-end, leave, drop");
    input.what = std::move(*command);
    return input;
}

/// Of time between two looks that counts: a slow picture, but no standstill.
constexpr double longest_step_s = 0.1;

}  // namespace

double ScriptClock::at(double now_s, bool stands) {
    if (!stands) time_s_ += std::min(now_s - seen_s_, longest_step_s);
    seen_s_ = now_s;
    return time_s_;
}

Result<std::vector<ScriptedInput>> read_window_script(const std::filesystem::path& file) {
    constexpr std::size_t largest = std::size_t{16} << 20;
    auto text = read_given_file(file, "script " + file.string(),
                                "a file of timed inputs (docs/play-options.md)", largest);
    const auto refuse = [](Error error) {
        error.hints = {{Setting::script}};
        return error;
    };
    if (!text.ok()) return refuse(text.error());
    std::istringstream in(std::move(*text));
    std::vector<ScriptedInput> inputs;
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string::npos || line[first] == '#') continue;
        const std::string where = "script " + file.string() + ", line " + std::to_string(number);
        while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
        auto input = read_line(line);
        if (!input.ok()) return refuse(input_error(where + ": " + input.error().message));
        if (!inputs.empty() && input->seconds < inputs.back().seconds)
            return refuse(input_error(where + ": its time is before that of the line above"));
        inputs.push_back(std::move(*input));
    }
    return inputs;
}

}  // namespace touchable
