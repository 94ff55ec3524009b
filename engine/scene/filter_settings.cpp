// SPDX-License-Identifier: Apache-2.0
// The table of filter settings, and the conversion of a setting's words and numbers.
#include "engine/base/words.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

/// Parses C, C+Q or C,Q; not zero. In a list, whose parts are separated by commas, C+Q is used.
std::optional<DepthLength> length_of(std::string_view word) {
    const auto whole = parsed_number(word);
    const std::size_t at = word.find(word.find(',') == std::string_view::npos ? '+' : ',');
    const bool has_two = !whole && at != std::string_view::npos;
    const auto constant = has_two ? parsed_number(word.substr(0, at)) : whole;
    const auto quadratic = has_two ? parsed_number(word.substr(at + 1)) : 0.0;
    if (!constant || !quadratic || *constant < 0 || *quadratic < 0) return std::nullopt;
    return *constant + *quadratic > 0 ? std::optional(DepthLength{*constant, *quadratic}) : std::nullopt;
}

/// A missing reach is left open unless terrace removal is stated to be on or off.
bool removal_is_open(const FilterSettings& filter, const FilterSet& unstated) {
    return unstated.terraces || filter.terraces == TerraceRemoval::automatic;
}

/// Makes a row of the members of FilterSetting that most rows have.
template <auto member>
FilterSetting filter_row(const char* name, SettingRange range, bool FilterSet::*open = nullptr,
                         const char* what = "", const char* in_list = "", const char* usual = "") {
    constexpr bool is_length = std::is_same_v<decltype(member), DepthLength FilterSettings::*>;
    range.is_length = is_length;
    const auto of = [](const FilterSettings& filter) -> DepthLength {
        if constexpr (is_length)
            return filter.*member;
        else
            return {static_cast<double>(filter.*member), 0};
    };
    const auto set = [](FilterSettings& filter, const DepthLength& value) {
        if constexpr (is_length)
            filter.*member = value;
        else
            filter.*member = static_cast<std::remove_reference_t<decltype(filter.*member)>>(value.constant);
    };
    return {.name = name,
            .value = {of, set},
            .range = std::move(range),
            .open = open,
            .what = what,
            .in_list = in_list,
            .usual = usual};
}

std::vector<FilterSetting> all_filter_settings() {
    using Filter = FilterSettings;
    using Open = FilterSet;
    FilterSetting reach = filter_row<&Filter::terrace_reach>(
        "terrace_reach", {.words = {"16", "32", "64", "128"}, .whole = true, .unit = "pixels"},
        &Open::terrace_reach);
    reach.opens = removal_is_open;
    FilterSetting temporal = filter_row<&Filter::temporal>(
        "temporal", {.words = {"off", "on"}}, &Open::temporal,
        "Reduces noise from frame to frame. Give the noise, or it is measured.", "temporal[=C[+Q]]", "on");
    temporal.length = &Filter::temporal_noise;
    return {
        filter_row<&Filter::median>(
            "median", {.words = {"0", "3", "5"}, .whole = true}, &Open::median,
            "Takes out single wrong pixels: each becomes the median of its 3 x 3 or 5 x 5 neighbours.",
            "median[=3|5]", "5"),
        filter_row<&Filter::fill_holes>(
            "fill_holes", {.most = 16, .whole = true, .unit = "passes"}, &Open::fill_holes,
            "Fills gaps in depth from their edges, one pixel with each pass.", "holes[=PASSES]", "2"),
        filter_row<&Filter::terraces>("terraces", {.words = {"off", "on", "auto"}}, &Open::terraces,
                                      "Smooths the steps (terraces) of coarsely stored depth.", "terraces",
                                      "on"),
        filter_row<&Filter::terrace_noise>("terrace_noise", {.most = 4, .unit = "codes"}),
        std::move(reach),
        filter_row<&Filter::levels>("levels", {}),
        std::move(temporal),
        filter_row<&Filter::temporal_noise>("temporal_noise", {}),
        filter_row<&Filter::flying_pixels>("flying_pixels", {}, &Open::flying_pixels, "", "flying=C[+Q]")};
}

}  // namespace

std::optional<double> SettingRange::value_of(std::string_view word) const {
    for (std::size_t k = 0; k < words.size(); ++k)
        if (word == words[k]) return whole ? parsed_number(word) : static_cast<double>(k);
    const auto number = words.empty() ? parsed_number(word) : std::nullopt;
    const bool has_digits_alone = word.find_first_of(".eE") == std::string_view::npos;
    return number && has(*number) && (!whole || has_digits_alone) ? number : std::nullopt;
}

std::string SettingRange::word_of(double value) const {
    for (const char* const word : words)
        if (value_of(word) == value) return word;
    return formatted("%.4g", value);
}

bool SettingRange::has(double value) const {
    if (words.empty()) return value >= least && value <= most && (!whole || value == std::floor(value));
    return std::ranges::any_of(words, [&](const char* word) { return value_of(word) == value; });
}

std::string SettingRange::in_words() const {
    if (is_length) return "a length above 0 in scene units, C or C+Q for C + Q depth^2, such as 1.5+2e-6";
    const char* const kind = whole ? "whole number" : "number";
    std::string right = words.empty() ? formatted("a %s from %.4g to %.4g", kind, least, most) : "";
    for (const char* const& word : words) {
        right += (&word == &words.front() ? "" : &word == &words.back() ? " or " : ", ") + std::string(word);
        if (whole && right == "0") right += " (off)";
    }
    return right + (*unit ? " " : "") + unit;
}

bool FilterSetting::read(std::string_view word, FilterSettings& filter) const {
    const auto plain = range.is_length ? std::nullopt : range.value_of(word);
    const auto typed = range.is_length || (length && !plain) ? length_of(word) : std::nullopt;
    if (!plain && !typed) return false;
    value.set(filter, range.is_length ? *typed : DepthLength{plain.value_or(1)});
    if (length) filter.*length = typed.value_or(DepthLength{});
    return true;
}

std::string FilterSetting::right() const {
    return range.in_words() + (length ? ", or " + SettingRange{.is_length = true}.in_words() : "");
}

void FilterSetting::copy(const FilterSettings& from, FilterSettings& to) const {
    value.set(to, value.of(from));
    if (length && from.*length != DepthLength{}) to.*length = from.*length;
}

std::span<const FilterSetting> filter_settings() {
    static const std::vector<FilterSetting> settings = all_filter_settings();
    return settings;
}

}  // namespace touchable
