#include "player/window/window_command.hpp"

#include <sstream>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/brush.hpp"
#include "player/window/keys.hpp"
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

constexpr int most_column = 16383;
constexpr std::int64_t most_frame = 999'999'999;

std::optional<std::int64_t> whole_number(std::string_view word, std::int64_t most) {
    std::int64_t value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool is_one = failure == std::errc() && end == word.data() + word.size();
    return is_one && value >= 0 && value <= most ? std::optional(value) : std::nullopt;
}

/// How many places a command takes, and the words for them.
struct Places {
    std::size_t least, most;
    const char* right;
};
Places places_of(WindowVerb verb) {
    if (verb == WindowVerb::paint) return {1, 1, "a pixel of the segment, X,Y or X,Y,FRAME, such as 120,80"};
    if (verb == WindowVerb::join)
        return {2, 2, "pixels of two segments, X,Y or X,Y,FRAME each, such as 120,80 200,90"};
    if (verb == WindowVerb::measure)
        return {2, 2,
                "two pixels of the depth, X,Y each, such as 120,80 200,90; nothing takes the tool or puts it "
                "away, and off takes the line away"};
    return {2, HeldBrush::most_points,
            "pixels of a stroke over one frame, X,Y or X,Y,FRAME each, such as 120,80 160,85 200,90"};
}

Result<WindowCommand> read_places(WindowVerb verb, const std::string& name, const std::string& rest) {
    const Places takes = places_of(verb);
    const auto refused = [&] {
        return usage_error(in_quotes(name + " " + rest) + ": " + name + " needs " + takes.right);
    };
    WindowCommand command{.verb = verb};
    std::istringstream words(rest);
    for (std::string word; words >> word;) {
        const auto place = read_pixel_of_frame(word);
        if (!place || command.places.size() == takes.most) return refused();
        if (verb == WindowVerb::measure && place->frame >= 0) return refused();  // it measures what is shown
        if (verb == WindowVerb::cut && !command.places.empty() && place->frame != command.places[0].frame)
            return refused();
        command.places.push_back(*place);
    }
    if (command.places.size() < takes.least) return refused();
    return command;
}

Result<WindowCommand> read_tool_words(WindowVerb verb, const std::string& name, const std::string& rest) {
    WindowCommand command{.verb = verb, .word = rest};
    switch (verb) {
        case WindowVerb::tool:
            if (!rest.empty() && !brush_tool_of(rest))
                return usage_error(
                    in_quotes(name + " " + rest) +
                    ": right would be touch, paint, join or cut; nothing puts it away, or takes "
                    "the last one again");
            return command;
        case WindowVerb::measure:
            return rest.empty() || rest == "off" ? command : read_places(verb, name, rest);
        case WindowVerb::otherwise:
            if (rest == "guess") command.word.clear();
            if (rest != "guess" && !find_material(rest))
                return usage_error("otherwise: " + no_such_material(rest) + ", or guess");
            return command;
        case WindowVerb::material:
            if (!find_material(rest)) return usage_error("material: " + no_such_material(rest));
            return command;
        case WindowVerb::save_materials:
            if (!rest.empty() && !rest.ends_with(".json"))
                return usage_error(in_quotes(name + " " + rest) + ": such a file's name ends in .json");
            return command;
        default:
            return read_places(verb, name, rest);
    }
}

/// Null: no command has that name.
const NamedVerb* verb_of(const std::string& name) {
    const auto* const named = std::ranges::find(named_verbs, name, &NamedVerb::name);
    return named == std::end(named_verbs) ? nullptr : named;
}

Result<WindowCommand> read_size(const std::string& words, const std::string& rest) {
    WindowCommand command{.verb = WindowVerb::size};
    const std::size_t cross = std::min(rest.find('x'), rest.size());
    const auto width = parsed_number(rest.substr(0, cross));
    const auto height = parsed_number(rest.substr(std::min(rest.size(), cross + 1)));
    command.width = static_cast<int>(std::clamp(width.value_or(0), 0.0, 1e5));
    command.height = static_cast<int>(std::clamp(height.value_or(0), 0.0, 1e5));
    const auto fits = [](int side) { return side >= 64 && side <= 8192; };
    if (!fits(command.width) || !fits(command.height))
        return usage_error("'" + words + "': size needs two numbers from 64 to 8192, such as 1280x720");
    return command;
}

Result<WindowCommand> read_number(const NamedVerb& named, const std::string& words, const std::string& rest) {
    const auto number = parsed_number(rest);
    const bool is_whole = named.verb == WindowVerb::fingers || named.verb == WindowVerb::step ||
                          named.verb == WindowVerb::answer;
    if (!number || (is_whole && *number != std::floor(*number)) || *number < named.least ||
        *number > named.most)
        return usage_error("'" + words + "': " + named.name + " needs a " + (is_whole ? "whole " : "") +
                           formatted("number from %g to %g", named.least, named.most));
    return WindowCommand{.verb = named.verb, .number = *number};
}

Result<WindowCommand> read_word(const NamedVerb& named, const std::string& words, const std::string& rest) {
    if (named.verb == WindowVerb::settings && !rest.empty() && rest != "a" && rest != "b")
        return usage_error("'" + words + "': there are settings a and b, and nothing is the other of them");
    if (named.verb == WindowVerb::overlay) TRY(overlay_after(Overlay::colour, rest));
    if (named.verb == WindowVerb::screenshot && !rest.empty() && !rest.ends_with(".png"))
        return usage_error("'" + words + "': a picture's name ends in .png");
    if (rest.empty() && named.takes == Takes::word)
        return usage_error("'" + std::string(named.name) + "' needs a name");
    return WindowCommand{.verb = named.verb, .word = rest};
}

bool ends(std::istringstream& words) {
    std::string more;
    return !(words >> more);
}

/// Keys of a study, beside key_bindings(), that a script may press.
constexpr const char* study_keys[] = {"enter", "6", "7", "8"};
constexpr std::int64_t most_scripted = 10;  // fingers on a touch screen

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
    TRY_ASSIGN(auto event, read_input(rest));
    if (event) {
        event->seconds = input.seconds;
        input.what = std::move(*event);
        return input;
    }
    auto command = parse_window_command(rest);
    const std::string name = rest.substr(0, rest.find(' '));
    if (!command && (session_setting(name) || verb_of(name))) return command.error();
    if (!command)
        return usage_error(command.error().message +
                           "; or an input: move, press, release, wheel, key, key-up, touch, touch-move, "
                           "touch-end, leave, drop");
    input.what = std::move(*command);
    return input;
}

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
    using enum WindowVerb;
    return is_one_of(
        verb, {turn, tilt, seek_by, step, deeper, point_right, point_down, nearer, louder, undo, redo});
}

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
    const NamedVerb* const named = verb_of(name);
    if (!named) {
        std::string known;
        for (const NamedVerb& verb : named_verbs)
            known += (known.empty() ? "" : ", ") + std::string(verb.name);
        for (const SessionSetting& setting : session_settings()) known += ", " + setting.name;
        return usage_error("'" + name + "' is no command of the window; there are " + known);
    }
    switch (named->takes) {
        case Takes::of_tool:
            return read_tool_words(named->verb, name, rest);
        case Takes::nothing:
            if (!rest.empty()) return usage_error("'" + name + "' takes nothing, and not '" + rest + "'");
            return WindowCommand{.verb = named->verb};
        case Takes::on_or_off:
            if (rest != "on" && rest != "off")
                return usage_error("'" + words + "': " + name + " is on or off");
            return WindowCommand{.verb = named->verb, .number = rest == "on" ? 1.0 : 0.0};
        case Takes::size:
            return read_size(words, rest);
        case Takes::number:
            return read_number(*named, words, rest);
        default:
            return read_word(*named, words, rest);
    }
}

Result<std::vector<ScriptedInput>> read_window_script(const std::filesystem::path& file) {
    constexpr std::size_t largest = std::size_t{16} << 20;
    auto text = read_given_file(file, "script " + file.string(),
                                "a file of timed inputs (docs/play-options.md)", largest);
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
