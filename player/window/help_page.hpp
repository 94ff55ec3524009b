#pragma once

#include <string>
#include <vector>

#include "player/window/panel_contents.hpp"

namespace touchable {

/// What keys, mouse and touch screen do, under titles.
struct HelpGroup {
    struct Row {
        std::string keys, what;
    };
    std::string title;
    std::vector<Row> rows;
};
/// All that does something now: by the keys' own list (key_groups), and the gestures beside them.
std::vector<HelpGroup> help_groups(const PanelFacts& facts);

/// In the middle, in two columns where the window is wide enough, as large as is legible; what does not fit
/// is scrolled to, and that it is there is said. Between ImGuiLayer's `begin` and `draw`; ImGui::End is the
/// caller's. `scale` as in ScreenSize; sizes in pixels.
void begin_help(const PanelFacts& facts, float width, float height, float scale);

}  // namespace touchable
