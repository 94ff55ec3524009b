#include "player/window/brush_words.hpp"

#include <charconv>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "engine/authoring/palette.hpp"
#include "engine/base/printable.hpp"
#include "player/window/brush_tool.hpp"

namespace touchable {
namespace {

constexpr int most_column = 16383;
constexpr std::int64_t most_frame = 999'999'999;

std::optional<std::int64_t> whole_number(std::string_view word, std::int64_t most) {
    std::int64_t value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool is_one = failure == std::errc() && end == word.data() + word.size();
    return is_one && value >= 0 && value <= most ? std::optional(value) : std::nullopt;
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

namespace {

/// How many places a command takes, and how it is told.
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
        if (verb == WindowVerb::measure && place->frame >= 0) return refused();  // it is of what is seen
        if (verb == WindowVerb::cut && !command.places.empty() && place->frame != command.places[0].frame)
            return refused();
        command.places.push_back(*place);
    }
    if (command.places.size() < takes.least) return refused();
    return command;
}

}  // namespace

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

}  // namespace touchable
