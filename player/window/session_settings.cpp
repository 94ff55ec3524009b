// SPDX-License-Identifier: Apache-2.0
#include "player/window/session_settings.hpp"

#include "engine/base/words.hpp"

namespace touchable {

Result<void> SessionSettings::set(const std::string& name, const std::string& value) {
    const SessionSetting* const setting = session_setting(name);
    if (!setting)
        return usage_error("unknown setting '" + name + "'; must be one of " +
                           listed(session_settings(), &SessionSetting::name));
    const auto legal = setting->range.value_of(value);
    if (!legal)
        return usage_error(name + " '" + value + "' is not allowed; must be " + setting->range.in_words());
    if (name == "filters") drop(SettingOf::filters);
    if (name != "filters" || value != "clip") values_[name] = setting->range.word_of(*legal);
    return {};
}

std::string SessionSettings::in_words() const {
    std::string words;
    for (const SessionSetting& setting : session_settings())
        if (const auto value = values_.find(setting.name); value != values_.end())
            words += (words.empty() ? "" : ", ") + value->first + " " + value->second +
                     (*setting.range.unit ? " " : "") + setting.range.unit;
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
        if (const auto value = settings.values().find(setting.name);
            value != settings.values().end() && (setting.of != SettingOf::device || options.control))
            setting.set(*setting.range.value_of(value->second), options);
    // With amount 0 the clip keeps its own heights.
    if (options.clip.relief && options.clip.relief->settings.amount == 0) options.clip.relief.reset();
    return options;
}

std::map<std::string, std::string> settings_in_effect(const TouchSetup& setup) {
    std::map<std::string, std::string> values;
    for (const SessionSetting& setting : session_settings())
        if (setting.get) values[setting.name] = setting.get(setup);
    return values;
}

}  // namespace touchable
