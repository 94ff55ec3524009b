#include "player/window/session_settings.hpp"

#include "engine/base/words.hpp"

namespace touchable {
namespace {

/// As FilterSettings has it.
constexpr int most_passes = 16;

/// The values that the setting can have, for a message.
std::string right_values(const SessionSetting& setting) {
    if (setting.words.empty()) {
        const std::string range = formatted("%.4g to %.4g", setting.least, setting.most);
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

/// The value as it is kept; nothing: the setting cannot have it.
std::optional<std::string> settled(const SessionSetting& setting, const std::string& value) {
    if (!setting.words.empty()) {
        const bool known = std::ranges::find(setting.words, value) != setting.words.end();
        return known ? std::optional(value) : std::nullopt;
    }
    const auto number = number_of(value);
    if (!number || !(*number >= setting.least && *number <= setting.most)) return std::nullopt;
    if (setting.whole && *number != std::floor(*number)) return std::nullopt;
    return formatted("%.4g", *number);
}

/// Words for the values of something, in both directions.
template <class Value>
struct WordOf {
    const char* word;
    Value value;
};
constexpr WordOf<TouchMetric> metrics[] = {
    {"world", TouchMetric::world}, {"pixel", TouchMetric::pixel}, {"scaled", TouchMetric::scaled}};
constexpr WordOf<FrameInterpolation> interpolations[] = {{"hold", FrameInterpolation::hold},
                                                         {"linear", FrameInterpolation::linear}};
constexpr WordOf<TerraceRemoval> terrace_words[] = {
    {"off", TerraceRemoval::off}, {"on", TerraceRemoval::on}, {"auto", TerraceRemoval::automatic}};
constexpr WordOf<bool> off_and_on[] = {{"off", false}, {"on", true}};

template <class Value, std::size_t count>
std::vector<const char*> words_of(const WordOf<Value> (&all)[count]) {
    std::vector<const char*> words;
    for (const auto& one : all) words.push_back(one.word);
    return words;
}
template <class Value, std::size_t count>
Value value_of(const WordOf<Value> (&all)[count], const std::string& word) {
    for (const auto& one : all)
        if (word == one.word) return one.value;
    return all[0].value;
}
template <class Value, std::size_t count>
std::string word_for(const WordOf<Value> (&all)[count], Value value) {
    for (const auto& one : all)
        if (value == one.value) return one.word;
    return "";
}

int whole(const std::string& value) {
    return static_cast<int>(number_of(value).value_or(0));
}

/// Sets all filters at once, in place of what the command line says of them.
void apply_filters(const std::string& value, SessionOptions& options) {
    ClipChoice& clip = options.clip;
    clip.median.reset();
    clip.fill_holes.reset();
    clip.terraces.reset();
    clip.temporal.reset();
    clip.filters = value == "off" ? FiltersChoice{} : FiltersChoice{{}, all_unstated};
}

using Options = SessionOptions;

std::vector<SessionSetting> force_settings() {
    // Of the pointer as a device, which exerts no more.
    const DeviceLimits most = PointerSettings{}.limits;
    return {
        {.name = "metric",
         .what = "How lengths are measured: as they are (world), or in two ways that are there to compare: "
                 "by pixels and grey levels, as the first papers did (pixel), or those made equal (scaled).",
         .words = words_of(metrics),
         .apply = [](const std::string& value, Options& o) { o.metric = value_of(metrics, value); },
         .in_effect = [](const TouchSetup& s) { return word_for(metrics, s.settings.touch.metric); }},
        {.name = "interpolation",
         .what = "Between two frames the surface moves smoothly (linear), or it waits for the next (hold).",
         .words = words_of(interpolations),
         .apply = [](const std::string& value,
                     Options& o) { o.clip.interpolation = value_of(interpolations, value); },
         .in_effect = [](const TouchSetup& s) { return word_for(interpolations, s.scene.interpolation); }},
        {.name = "max-force",
         .what = "No force on a finger is ever larger.",
         .words = {},
         .least = 0.1,
         .most = most.max_force,
         .unit = "N",
         .apply = [](const std::string& value,
                     Options& o) { o.guard.max_force = number_of(value).value_or(0); },
         .in_effect = [](const TouchSetup& s) { return formatted("%.4g", s.settings.guard.max_force); }},
        {.name = "max-stiffness",
         .what =
             "How hard the surface can be at most: newtons for each millimetre that a finger is pressed in.",
         .words = {},
         .least = 0.1,
         .most = most.max_stiffness / 1000,
         .unit = "N/mm",
         .apply = [](const std::string& value,
                     Options& o) { o.guard.max_stiffness = number_of(value).value_or(0) * 1000; },
         .in_effect =
             [](const TouchSetup& s) { return formatted("%.4g", s.settings.guard.max_stiffness / 1000); }},
        {.name = "hand-scale",
         .what =
             "How far a finger goes for a way of the hand: at 1 the picture fits into the device's reach, "
             "below it is finer.",
         .words = {},
         .least = 0.01,
         .most = 100,
         .of_device = true,
         .by_ratio = true,
         .apply =
             [](const std::string& value, Options& o) {
                 if (o.control) o.hand_scale = number_of(value).value_or(1);
             },
         .in_effect = [](const TouchSetup& s) { return formatted("%.4g", s.hand_scale); }}};
}

std::vector<SessionSetting> filter_settings() {
    return {
        {.name = "filters",
         .what = "What cleans the depth before it is felt: as the clip asks for, as measured in its first "
                 "frames, or nothing.",
         .words = {"clip", "auto", "off"},
         .apply = apply_filters},
        {.name = "median",
         .what =
             "Takes out single wrong pixels: each becomes the middle one of its 3 x 3 or 5 x 5 neighbours.",
         .words = {"0", "3", "5"},
         .filter = true,
         .apply = [](const std::string& value, Options& o) { o.clip.median = whole(value); },
         .in_effect = [](const TouchSetup& s) { return std::to_string(s.scene.filter.median); }},
        {.name = "fill-holes",
         .what = "Closes gaps in the depth from their rims, one pixel with each pass.",
         .words = {},
         .most = most_passes,
         .whole = true,
         .unit = "passes",
         .filter = true,
         .apply = [](const std::string& value, Options& o) { o.clip.fill_holes = whole(value); },
         .in_effect = [](const TouchSetup& s) { return std::to_string(s.scene.filter.fill_holes); }},
        {.name = "terraces",
         .what = "Smooths the steps that coarsely stored depth has, as a hillside has terraces.",
         .words = words_of(terrace_words),
         .filter = true,
         .apply = [](const std::string& value,
                     Options& o) { o.clip.terraces = value_of(terrace_words, value); },
         .in_effect = [](const TouchSetup& s) { return word_for(terrace_words, s.scene.filter.terraces); }},
        {.name = "temporal",
         .what = "Calms depth that trembles from frame to frame, where nothing moves.",
         .words = words_of(off_and_on),
         .filter = true,
         .apply =
             [](const std::string& value, Options& o) {
                 o.clip.temporal = TemporalChoice{value_of(off_and_on, value), std::nullopt};
             },
         .in_effect = [](const TouchSetup& s) { return word_for(off_and_on, s.scene.filter.temporal); }}};
}

/// The relief as a person has set it so far; what is not set is as in `touchable relief`.
ReliefChoice& relief_of(SessionOptions& options) {
    if (!options.clip.relief) options.clip.relief.emplace().settings.amount = 0;
    return *options.clip.relief;
}
const ReliefChoice& relief_in(const TouchSetup& setup) {
    static const ReliefChoice none{.settings = {.amount = 0}};
    return setup.clip.relief ? *setup.clip.relief : none;
}

template <std::size_t band>
SessionSetting relief_band(const char* name, const char* what) {
    return {
        .name = name,
        .what = what,
        .words = {},
        .least = -400,
        .most = 400,
        .whole = true,
        .unit = "%",
        .of_relief = true,
        .apply = [](const std::string& value,
                    Options& o) { relief_of(o).settings.bands[band] = whole(value); },
        .in_effect = [](const TouchSetup& s) { return std::to_string(relief_in(s).settings.bands[band]); }};
}

std::vector<SessionSetting> relief_settings() {
    return {
        {.name = "relief",
         .what =
             "Makes a relief of the colour: what is bright stands out, in place of the clip's own heights. "
             "How much of the height its largest details get.",
         .words = {},
         .most = 400,
         .whole = true,
         .unit = "%",
         .of_relief = true,
         .apply = [](const std::string& value, Options& o) { relief_of(o).settings.amount = whole(value); },
         .in_effect = [](const TouchSetup& s) { return std::to_string(relief_in(s).settings.amount); }},
        {.name = "relief-height",
         .what = "The height of the relief, from the deepest to the highest, under the hand.",
         .words = {},
         .least = 0.05,
         .most = 5,
         .unit = "mm",
         .of_relief = true,
         .by_ratio = true,
         .apply = [](const std::string& value,
                     Options& o) { relief_of(o).height_mm = number_of(value).value_or(0.5); },
         .in_effect = [](const TouchSetup& s) { return formatted("%.4g", relief_in(s).height_mm); }},
        relief_band<0>("relief-fine",
                       "The share of details of 2 to 4 pixels; below 0 they are turned round."),
        relief_band<1>("relief-medium", "The share of details of 5 to 10 pixels."),
        relief_band<2>("relief-coarse", "The share of details of 11 to 25 pixels."),
        {.name = "relief-invert",
         .what = "What is dark stands out, not what is bright.",
         .words = words_of(off_and_on),
         .of_relief = true,
         .apply = [](const std::string& value,
                     Options& o) { relief_of(o).settings.invert = value_of(off_and_on, value); },
         .in_effect =
             [](const TouchSetup& s) { return word_for(off_and_on, relief_in(s).settings.invert); }}};
}

SessionSetting brush_setting() {
    return {.name = "materials",
            .what = "Segments feel as they are painted, or the clip as it does by itself.",
            .words = words_of(off_and_on),
            .of_brush = true,
            .apply =
                [](const std::string& value, Options& o) {
                    if (!value_of(off_and_on, value)) o.clip.painted.reset();
                },
            .in_effect = [](const TouchSetup& s) { return word_for(off_and_on, s.clip.painted != nullptr); }};
}

std::vector<SessionSetting> all_settings() {
    std::vector<SessionSetting> all = force_settings();
    for (const auto& some : {filter_settings(), relief_settings()})
        all.insert(all.end(), some.begin(), some.end());
    all.push_back(brush_setting());
    return all;
}

}  // namespace

std::optional<double> number_of(const std::string& word) {
    double value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc() || end != word.data() + word.size() || std::isnan(value)) return std::nullopt;
    return value;
}

std::span<const SessionSetting> session_settings() {
    static const std::vector<SessionSetting> settings = all_settings();
    return settings;
}

const SessionSetting* session_setting(const std::string& name) {
    for (const SessionSetting& setting : session_settings())
        if (name == setting.name) return &setting;
    return nullptr;
}

Result<void> SessionSettings::set(const std::string& name, const std::string& value) {
    const SessionSetting* const setting = session_setting(name);
    if (!setting) {
        std::string known;
        for (const SessionSetting& other : session_settings())
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
    for (const SessionSetting& other : session_settings())
        if (other.filter) values_.erase(other.name);
    values_.erase(name);
    if (*kept != "clip") values_[name] = *kept;
    return {};
}

std::string SessionSettings::in_words() const {
    std::string words;
    for (const SessionSetting& setting : session_settings())
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

SessionOptions with_settings(SessionOptions options, const SessionSettings& settings) {
    for (const SessionSetting& setting : session_settings())
        if (const auto value = settings.values().find(setting.name); value != settings.values().end())
            setting.apply(value->second, options);
    // Without any of it the clip has its own heights.
    if (options.clip.relief && options.clip.relief->settings.amount == 0) options.clip.relief.reset();
    return options;
}

std::map<std::string, std::string> settings_in_effect(const TouchSetup& setup) {
    std::map<std::string, std::string> values;
    for (const SessionSetting& setting : session_settings())
        if (setting.in_effect) values[setting.name] = setting.in_effect(setup);
    return values;
}

}  // namespace touchable
