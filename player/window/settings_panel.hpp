#pragma once

#include <map>
#include <string>
#include <vector>

#include "player/window/session_settings.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// What the panel shows of the settings of what is felt.
struct SettingsFacts {
    std::map<std::string, std::string> by_hand,
        in_effect;            ///< as SessionSettings and `settings_in_effect` have them
    std::string filters;      ///< each filter with its reason, in words
    std::string relief{};     ///< what keeps the relief; empty: there is none
    bool b_is_on = false;     ///< of the two sets
    bool has_device = false;  ///< one is held
};

/// The panel's parts for the settings of what is felt, a row each, where Dear ImGui's cursor is. `scale` as
/// in panel_rows.hpp.
class SettingsPanel {
public:
    void draw(const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked);
    void draw_relief(const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked);
    void draw_filters(const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked);

private:
    void draw_row(const SessionSetting& setting, const SettingsFacts& facts,
                  std::vector<WindowCommand>& asked);
    void draw_number(const SessionSetting& setting, const SettingsFacts& facts,
                     std::vector<WindowCommand>& asked);

    float scale_ = 1;
    std::string held_;   // the slider that somebody holds
    float dragged_ = 0;  // what it says
};

}  // namespace touchable
