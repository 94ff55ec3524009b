#include "player/commands/filters_option.hpp"

#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "engine/base/nearest_word.hpp"
#include "player/commands/temporal_option.hpp"

namespace touchable {
namespace {

Error refusal(std::string_view part, const std::string& why) {
    return usage_error("--filters '" + std::string(part) + "' will not do" + why +
                       "; right would be auto, off, or those that shall be on, such as "
                       "median=5,terraces,temporal=1.5+2e-6,holes=2");
}

/// What is wrong with a part of the list.
std::string why_not(std::string_view name) {
    const std::array<std::string, 5> names{"median", "holes", "terraces", "temporal", "flying"};
    if (name == "off" || name == "auto") return ": it stands alone, without other filters";
    if (name == "median") return ": the window's side is 3 or 5";
    if (name == "holes") return ": passes are a whole number, 1 to 16";
    if (name == "terraces") return ": it takes no value";
    if (name == "flying" || name == "temporal")
        return ": it needs a length above 0, in scene units, as in " + std::string(name) + "=1.5 or " +
               std::string(name) + "=1.5+2e-6";
    const std::string meant = nearest_word(name, names);
    return meant.empty() ? "" : ": did you mean " + meant + "?";
}

/// C or C+Q, not zero.
bool read_length(std::string_view value, DepthLength& length) {
    const auto read = as_depth_length(value, '+');
    if (read) length = *read;
    return read && *read != DepthLength{};
}

/// One word of the list; `value`: what stands behind its =, or nothing.
bool read_filter(std::string_view name, std::string_view value, FilterSettings& filter) {
    if (name == "median" && (value.empty() || value == "3" || value == "5")) {
        filter.median = value == "3" ? 3 : 5;
        return true;
    }
    if (name == "holes") {
        const double passes = value.empty() ? 2 : as_number(value).value_or(0);
        if (!(passes >= 1 && passes <= 16 && passes == std::floor(passes))) return false;
        filter.fill_holes = static_cast<int>(passes);
        return true;
    }
    if (name == "terraces" && value.empty()) {
        filter.terraces = TerraceRemoval::on;
        return true;
    }
    if (name == "flying") return read_length(value, filter.flying_pixels);
    if (name != "temporal") return false;
    filter.temporal = true;
    return value.empty() || read_length(value, filter.temporal_noise);
}

}  // namespace

CLI::Option* add_filters_option(CLI::App& sub, std::optional<std::string>& typed) {
    return sub
        .add_option(
            "--filters", typed,
            "all filters at once, instead of the scene's: off, auto (what the first frames ask for), or "
            "those that shall be on: median[=3|5], holes[=PASSES], terraces, temporal[=C[+Q]], "
            "flying=C[+Q], with commas between")
        ->type_name("WORD|LIST");
}

Result<FiltersChoice> read_filters(const std::string& typed) {
    if (typed == "off") return FiltersChoice{};
    if (typed == "auto") return FiltersChoice{{}, all_unstated};
    FiltersChoice choice;
    std::set<std::string_view> named;
    std::string_view rest = typed;
    for (bool more = true; more;) {
        const std::size_t comma = rest.find(',');
        more = comma != std::string_view::npos;
        const std::string_view part = rest.substr(0, comma);
        const std::size_t equals = part.find('=');
        const bool has_value = equals != std::string_view::npos;
        const std::string_view value = has_value ? part.substr(equals + 1) : std::string_view();
        const std::string_view name = part.substr(0, equals);
        if ((has_value && value.empty()) || !read_filter(name, value, choice.settings))
            return refusal(part, why_not(name));
        if (!named.insert(name).second) return refusal(part, ": " + std::string(name) + " is named twice");
        if (more) rest.remove_prefix(comma + 1);
    }
    return choice;
}

}  // namespace touchable
