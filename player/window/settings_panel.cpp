#include "player/window/settings_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <string_view>

#include "engine/base/number_words.hpp"
#include "player/window/panel_rows.hpp"

namespace touchable {
namespace {

std::string value_in(const std::map<std::string, std::string>& values, const char* name,
                     const char* otherwise = "") {
    const auto value = values.find(name);
    return value == values.end() ? otherwise : value->second;
}

void ask_for(const SessionSetting& setting, const std::string& value, std::vector<WindowCommand>& asked) {
    asked.push_back({WindowVerb::feel, 0, setting.name + (" " + value)});
}

/// What was chosen by hand, otherwise what is in effect.
void draw_choice(const SessionSetting& setting, const SettingsFacts& facts,
                 std::vector<WindowCommand>& asked) {
    const bool by_hand = facts.by_hand.contains(setting.name);
    const std::string value =
        value_in(by_hand ? facts.by_hand : facts.in_effect, setting.name, setting.words.front());
    int chosen = -1;
    std::vector<const char*> words;
    for (const std::string word : setting.words) {
        if (value == word) chosen = static_cast<int>(words.size());
        words.push_back(word == "0" ? "off" : setting.words[words.size()]);
    }
    const int clicked = draw_words(setting.name, words, chosen, by_hand);
    if (clicked >= 0) ask_for(setting, setting.words[static_cast<std::size_t>(clicked)], asked);
}

/// Each filter with its reason, a line each: what stands between parentheses is no end of one.
void draw_reasons(const std::string& words) {
    int depth = 0;
    std::string line;
    const auto say = [](std::string remark) {
        constexpr std::string_view stated = "(stated)";
        if (const std::size_t at = remark.find(stated); at != std::string::npos)
            remark.replace(at, stated.size(), "(asked for)");
        draw_remark(remark);
    };
    for (std::size_t k = 0; k < words.size(); ++k) {
        depth += words[k] == '(' ? 1 : (words[k] == ')' ? -1 : 0);
        line += words[k];
        const bool ends = k + 1 == words.size() || (depth == 0 && words[k + 1] == ' ' &&
                                                    (words[k] == ',' || words[k] == ';' || words[k] == ':'));
        if (!ends) continue;
        if (k + 1 < words.size()) line.pop_back();
        say(line);
        line.clear();
        ++k;  // the space
    }
}

bool is_of_filters(const SessionSetting& setting) {
    return setting.filter || std::string_view(setting.name) == "filters";
}

std::string shown_number(const SessionSetting& setting, float value) {
    return formatted(setting.whole ? "%.0f" : (setting.by_ratio ? "%.3g" : "%.2g"),
                     static_cast<double>(value));
}

}  // namespace

/// Takes effect when the slider is let go.
void SettingsPanel::draw_number(const SessionSetting& setting, const SettingsFacts& facts,
                                std::vector<WindowCommand>& asked) {
    const auto in_effect = number_of(value_in(facts.in_effect, setting.name)).value_or(setting.least);
    const std::string id = std::string("##") + setting.name;
    auto value = held_ == setting.name ? dragged_ : static_cast<float>(in_effect);
    const std::string number = shown_number(setting, value);
    const bool may_be_off = setting.filter || std::string_view(setting.name) == "relief";
    const std::string words = may_be_off && number == "0" ? "off" : number + " " + setting.unit;
    draw_slider(id.c_str(), value, static_cast<float>(setting.least), static_cast<float>(setting.most), words,
                scale_, setting.by_ratio ? ImGuiSliderFlags_Logarithmic : 0);
    if (ImGui::IsItemActive()) {
        held_ = setting.name;
        dragged_ = value;
    } else if (held_ == setting.name) {
        held_.clear();
    }
    if (ImGui::IsItemDeactivatedAfterEdit()) ask_for(setting, shown_number(setting, dragged_), asked);
}

void SettingsPanel::draw_row(const SessionSetting& setting, const SettingsFacts& facts,
                             std::vector<WindowCommand>& asked) {
    std::string label = std::string_view(setting.name) == "filters" ? "all at once" : setting.name;
    std::replace(label.begin(), label.end(), '-', ' ');
    draw_label(label, scale_);
    if (setting.words.empty())
        draw_number(setting, facts, asked);
    else
        draw_choice(setting, facts, asked);
    explain_row(setting.what);
}

void SettingsPanel::draw(const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    scale_ = scale;
    draw_label("settings", scale_);
    if (const int set = draw_words("settings", {"A", "B"}, facts.b_is_on ? 1 : 0, true); set >= 0)
        asked.push_back({WindowVerb::settings, 0, set == 0 ? "a" : "b"});
    explain_row(
        "Two sets of settings, to feel the difference. The key B switches; B begins without filters, or "
        "where materials are painted, without those.");
    for (const SessionSetting& setting : session_settings())
        if (!is_of_filters(setting) && !setting.of_relief && !setting.of_brush &&
            (facts.has_device || !setting.of_device))
            draw_row(setting, facts, asked);
}

void SettingsPanel::draw_filters(const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    scale_ = scale;
    for (const SessionSetting& setting : session_settings())
        if (is_of_filters(setting)) draw_row(setting, facts, asked);
    draw_reasons(facts.filters);
}

void SettingsPanel::draw_relief(const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked) {
    scale_ = scale;
    for (const SessionSetting& setting : session_settings())
        if (setting.of_relief) draw_row(setting, facts, asked);
    if (!facts.relief.empty()) draw_remark(facts.relief);
}

}  // namespace touchable
