// SPDX-License-Identifier: Apache-2.0
#include "engine/base/words.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {
namespace {

/// Finds a setting's value in SessionOptions and in TouchSetup.
struct Place {
    static SessionOptions& options(SessionOptions& options) { return options; }
    static const SessionOptions& options(const TouchSetup& setup) { return setup.options; }
    static auto& interpolation(SessionOptions& options) {
        return options.clip.interpolation ? *options.clip.interpolation
                                          : options.clip.interpolation.emplace();
    }
    static const auto& interpolation(const TouchSetup& setup) { return setup.scene.interpolation; }
    /// The user's relief so far; unset values are the defaults of `touchable relief`.
    static ReliefChoice& relief(SessionOptions& options) {
        if (!options.clip.relief) options.clip.relief.emplace().settings.amount = 0;
        return *options.clip.relief;
    }
    static const ReliefChoice& relief(const TouchSetup& setup) {
        static const ReliefChoice none{.settings = {.amount = 0}};
        return setup.options.clip.relief ? *setup.options.clip.relief : none;
    }
};

/// `in`: returns the value in SessionOptions and in TouchSetup; a stored number is `per_unit` times the
/// setting.
template <class In>
SessionSetting setting_row(SettingOf of, const char* name, const char* what, const SettingRange& range, In in,
                           double per_unit = 1) {
    SessionSetting setting{.name = name, .what = what, .of = of, .range = range};
    setting.set = [in, per_unit](double number, SessionOptions& options) {
        auto& value = in(options);
        value = static_cast<std::remove_reference_t<decltype(value)>>(number * per_unit);
    };
    setting.get = [in, range, per_unit](const TouchSetup& setup) {
        return range.word_of(static_cast<double>(in(setup)) / per_unit);
    };
    SessionOptions usual;
    if (range.words.empty()) setting.usual = range.word_of(static_cast<double>(in(usual)) / per_unit);
    return setting;
}

std::vector<SessionSetting> all_settings() {
    using enum SettingOf;
    const auto in_guard = [](auto member) {
        return [member](auto& run) -> auto& {
            return Place::options(run).guard.*member;
        };
    };
    const auto share_of = [](std::size_t band, const char* name, const char* what) {
        return setting_row(
            relief, name, what,
            {.least = -400, .most = 400, .whole = true, .unit = "%"}, [band](auto& run) -> auto& {
                return Place::relief(run).settings.bands[band];
            });
    };
    constexpr double per_mm = 1000;  // N/m of N/mm
    std::vector<SessionSetting> all{
        setting_row(
            felt, "metric",
            "How lengths are measured. As they are (world), or in two ways that are there to compare: in "
            "pixels and grey levels, as the first papers did (pixel), or those made equal (scaled).",
            {.words = {"world", "pixel", "scaled"}},
            [](auto& run) -> auto& { return Place::options(run).touch.metric; }),
        setting_row(
            felt, "interpolation",
            "How the surface moves between two frames: smoothly (linear), or not until the next (hold).",
            {.words = {"hold", "linear"}}, [](auto& run) -> auto& { return Place::interpolation(run); }),
        // 20 N: the most that a pointer exerts in a window.
        setting_row(felt, "max-force", "The largest force on a finger.",
                    {.least = 0.1, .most = 20, .unit = "N"}, in_guard(&GuardSettings::max_force)),
        setting_row(
            felt, "max-stiffness",
            "How hard the surface can be at most. Newtons for each millimetre that a finger is pressed in.",
            {.least = 0.1, .most = 10, .unit = "N/mm"}, in_guard(&GuardSettings::max_stiffness), per_mm),
        setting_row(
            device, "hand-scale",
            "Scale from device motion to scene motion. 1: the device's reach covers the picture; 0.5: half "
            "as far.",
            {.least = 0.01, .most = 100, .by_ratio = true},
            [](auto& run) -> auto& { return Place::options(run).hand_scale; }),
        {.name = "filters",
         .what = "What cleans the depth before it is felt: as the clip asks for, as measured in its first "
                 "frames, or nothing.",
         .of = filters,
         .range = {.words = {"clip", "auto", "off"}},
         .set = [](double place, SessionOptions& options) {
             options.clip.single_filters = {};  // drops single filters' settings, and detail
             options.clip.filters =
                 place == 2 ? ClipChoice::Filters::off() : ClipChoice::Filters{.measured = all_unstated};
         }}};
    const SettingRange details{.most = 1};
    all.push_back({"detail", detail_words, filters, details,
                   [](double value, SessionOptions& run) { run.clip.single_filters.measured.detail = value; },
                   [details](const TouchSetup& setup) {
                       const bool is_known = setup.filters && setup.filters->measured;
                       const auto detail =
                           is_known ? setup.filters->measured->detail_of(setup.scene.filter) : std::nullopt;
                       return detail ? details.word_of(*detail) : "";
                   }});
    for (const FilterSetting& filter : filter_settings())
        if (*filter.what)
            all.push_back({with_dashes(filter.name), filter.what, filters, filter.range,
                           [&filter](double value, SessionOptions& options) {
                               options.clip.single_filters.state(filter, filter.range.word_of(value));
                           },
                           [&filter](const TouchSetup& setup) {
                               return filter.range.word_of(filter.value.of(setup.scene.filter).constant);
                           }});
    const std::vector<SessionSetting> rest{
        setting_row(
            relief, "relief",
            "Makes a relief of the colour: what is bright stands out, in place of the clip's own heights. "
            "How much of the height its largest details get.",
            {.most = 400, .whole = true, .unit = "%"},
            [](auto& run) -> auto& { return Place::relief(run).settings.amount; }),
        setting_row(
            relief, "relief-height",
            "The height of the relief, from the deepest to the highest, under the hand.",
            {.least = 0.05, .most = 5, .unit = "mm", .by_ratio = true},
            [](auto& run) -> auto& { return Place::relief(run).height_mm; }),
        share_of(0, "relief-fine", "The share of details of 2 to 4 pixels; below 0 they are turned round."),
        share_of(1, "relief-medium", "The share of details of 5 to 10 pixels."),
        share_of(2, "relief-coarse", "The share of details of 11 to 25 pixels."),
        setting_row(
            relief, "relief-invert", "What is dark stands out, not what is bright.", {.words = {"off", "on"}},
            [](auto& run) -> auto& { return Place::relief(run).settings.invert; }),
        {.name = "materials",
         .what = "Segments feel as they are painted, or the clip as it does by itself.",
         .of = brush,
         .range = {.words = {"off", "on"}},
         .set =
             [](double is_on, SessionOptions& options) {
                 if (is_on == 0) options.clip.painted.reset();
             },
         .get =
             [](const TouchSetup& setup) { return std::string(setup.options.clip.painted ? "on" : "off"); }},
        setting_row(
            expert, "stribeck",
            "Speed about which friction falls from static to dynamic. 0: as soon as the finger slides.",
            {.unit = "m/s"}, [](auto& run) -> auto& { return Place::options(run).touch.stribeck_speed; }),
        setting_row(
            expert, "stiffness",
            "Stiffness in contact: the clip's (map), or rising only as far as losses pay for it (passive).",
            {.words = {"map", "passive"}},
            [](auto& run) -> auto& { return Place::options(run).guard.rise.paid; }),
        setting_row(
            expert, "stiffness-slew",
            "How fast stiffness may rise under a finger that moves over the surface. 1e9: at once.",
            {.unit = "N/mm per second"},
            [](auto& run) -> auto& { return Place::options(run).guard.rise.per_tick; }, per_mm* tick_seconds),
        setting_row(expert, "damping", "Damping of the hand's motion, beside the spring.", {.unit = "N s/m"},
                    in_guard(&GuardSettings::damping)),
        setting_row(expert, "passivity",
                    "Largest damping with which the passivity controller removes energy that the contact "
                    "created. 0: off.",
                    {.unit = "N s/m"}, in_guard(&GuardSettings::passivity))};
    all.insert(all.end(), rest.begin(), rest.end());
    // Beyond what a hand takes: a robot that is driven over the network.
    for (SessionSetting& setting : all) {
        if (setting.name == "max-force") setting.typed = {0.001, 1000};
        if (setting.name == "max-stiffness") setting.typed = {0.001, 50};
    }
    return all;
}

}  // namespace

std::span<const SessionSetting> run_settings() {
    static const std::vector<SessionSetting> settings = all_settings();
    return settings;
}

std::span<const SessionSetting> session_settings() {
    const auto all = run_settings();
    return {all.begin(), std::ranges::find(all, SettingOf::expert, &SessionSetting::of)};
}

const SessionSetting* session_setting(std::string_view name) {
    const auto all = session_settings();
    return named_in(all, name, &SessionSetting::name);
}

}  // namespace touchable
