#include "player/window/felt_settings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

namespace touchable {
namespace {

/// As many as an option of the command line takes.
constexpr int most_passes = 16;
/// Of the pointer as a device: it can exert no more than 20 N and 10 N/mm.
constexpr double most_newtons = 20, most_newtons_per_mm = 10;

std::string short_number(double number) {
    char words[32];
    std::snprintf(words, sizeof words, "%.4g", number);
    return words;
}

const char* word_of(TerraceRemoval terraces) {
    switch (terraces) {
        case TerraceRemoval::off:
            return "off";
        case TerraceRemoval::on:
            return "on";
        case TerraceRemoval::automatic:
            break;
    }
    return "auto";
}

/// What the setting can be, for whoever meant something else.
std::string right_values(const FeltSetting& setting) {
    if (setting.words.empty()) {
        const std::string range = short_number(setting.least) + " to " + short_number(setting.most);
        return (setting.whole ? "a whole number from " : "a number from ") + range +
               (*setting.unit ? std::string(" ") + setting.unit : "");
    }
    std::string words;
    for (std::size_t k = 0; k < setting.words.size(); ++k) {
        const bool last = k + 1 == setting.words.size();
        words += (k == 0 ? "" : (last ? " or " : ", ")) + std::string(setting.words[k]);
    }
    return words;
}

/// The value as it is kept; nothing where it is none.
std::optional<std::string> settled(const FeltSetting& setting, const std::string& value) {
    if (!setting.words.empty()) {
        const bool known =
            std::find(setting.words.begin(), setting.words.end(), value) != setting.words.end();
        return known ? std::optional(value) : std::nullopt;
    }
    const auto number = number_of(value);
    if (!number || !(*number >= setting.least && *number <= setting.most)) return std::nullopt;
    if (setting.whole && *number != std::floor(*number)) return std::nullopt;
    return short_number(*number);
}

/// `value` was settled before.
void apply(const std::string& name, const std::string& value, SessionOptions& options) {
    ClipChoice& clip = options.clip;
    const auto number = [&value] { return number_of(value).value_or(0); };
    if (name == "metric")
        for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled})
            if (name_of(metric) == value) options.metric = metric;
    if (name == "interpolation")
        clip.interpolation = value == "hold" ? FrameInterpolation::hold : FrameInterpolation::linear;
    if (name == "max-force") options.guard.max_force = number();
    if (name == "max-stiffness") options.guard.max_stiffness = number() * 1000;
    if (name == "median") clip.median = static_cast<int>(number());
    if (name == "fill-holes") clip.fill_holes = static_cast<int>(number());
    if (name == "terraces")
        for (const auto terraces : {TerraceRemoval::off, TerraceRemoval::on, TerraceRemoval::automatic})
            if (word_of(terraces) == value) clip.terraces = terraces;
    if (name == "temporal") clip.temporal = TemporalChoice{value == "on", std::nullopt};
}

/// All filters at once, in place of what the command line says of them.
void apply_filters(const std::string& value, ClipChoice& clip) {
    clip.median.reset();
    clip.fill_holes.reset();
    clip.terraces.reset();
    clip.temporal.reset();
    clip.filters = value == "off" ? FiltersChoice{} : FiltersChoice{{}, all_unstated};
}

}  // namespace

std::optional<double> number_of(const std::string& word) {
    double value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc() || end != word.data() + word.size() || std::isnan(value)) return std::nullopt;
    return value;
}

std::span<const FeltSetting> felt_settings() {
    static const std::vector<FeltSetting> settings{
        {.name = "metric", .words = {"world", "pixel", "scaled"}},
        {.name = "interpolation", .words = {"hold", "linear"}},
        {.name = "max-force", .words = {}, .least = 0.1, .most = most_newtons, .unit = "N"},
        {.name = "max-stiffness", .words = {}, .least = 0.1, .most = most_newtons_per_mm, .unit = "N/mm"},
        {.name = "filters", .words = {"clip", "auto", "off"}},
        {.name = "median", .words = {"0", "3", "5"}, .filter = true},
        {.name = "fill-holes",
         .words = {},
         .most = most_passes,
         .whole = true,
         .unit = "passes",
         .filter = true},
        {.name = "terraces", .words = {"off", "on", "auto"}, .filter = true},
        {.name = "temporal", .words = {"off", "on"}, .filter = true}};
    return settings;
}

const FeltSetting* felt_setting(const std::string& name) {
    for (const FeltSetting& setting : felt_settings())
        if (name == setting.name) return &setting;
    return nullptr;
}

Result<void> FeltSettings::set(const std::string& name, const std::string& value) {
    const FeltSetting* const setting = felt_setting(name);
    if (!setting) {
        std::string known;
        for (const FeltSetting& other : felt_settings())
            known += (known.empty() ? "" : ", ") + std::string(other.name);
        return usage_error("'" + name + "' is no setting of what is felt; there are " + known);
    }
    const auto kept = settled(*setting, value);
    if (!kept)
        return usage_error(name + " '" + value + "' will not do; right would be " + right_values(*setting));
    if (name != "filters") {
        values_[name] = *kept;
        return {};
    }
    for (const FeltSetting& other : felt_settings())
        if (other.filter) values_.erase(other.name);
    values_.erase(name);
    if (*kept != "clip") values_[name] = *kept;
    return {};
}

std::string FeltSettings::in_words() const {
    std::string words;
    for (const FeltSetting& setting : felt_settings())
        if (const auto value = values_.find(setting.name); value != values_.end())
            words += (words.empty() ? "" : ", ") + value->first + " " + value->second +
                     (*setting.unit ? std::string(" ") + setting.unit : "");
    return words.empty() ? "as the clip says" : words;
}

void TwoSettings::turn_to(bool to_b) {
    if (to_b && !b) {
        b = a;
        (void)b->set("filters", "off");
    }
    b_is_on = to_b;
}

SessionOptions with_felt(SessionOptions options, const FeltSettings& felt) {
    const auto& values = felt.values();
    if (const auto filters = values.find("filters"); filters != values.end())
        apply_filters(filters->second, options.clip);
    for (const auto& [name, value] : values) apply(name, value, options);
    return options;
}

std::map<std::string, std::string> felt_in(const TouchSetup& setup) {
    const FilterSettings& filter = setup.scene.filter;
    const GuardSettings& guard = setup.settings.guard;
    const bool holds = setup.scene.interpolation == FrameInterpolation::hold;
    return {{"metric", std::string(name_of(setup.settings.touch.metric))},
            {"interpolation", holds ? "hold" : "linear"},
            {"max-force", short_number(guard.max_force)},
            {"max-stiffness", short_number(guard.max_stiffness / 1000)},
            {"median", std::to_string(filter.median)},
            {"fill-holes", std::to_string(filter.fill_holes)},
            {"terraces", word_of(filter.terraces)},
            {"temporal", filter.temporal ? "on" : "off"}};
}

}  // namespace touchable
