#pragma once

#include <vector>

#include "player/control/window_command.hpp"
#include "player/panel/panel_contents.hpp"

namespace touchable {

/// The bar below: play, seek, speed, and what else there is room for.
class PlaybackBar {
public:
    /// `scale` as in ScreenSize. Between begin_box and ImGui::End.
    void draw(const PanelFacts& facts, float width, float height, float scale,
              std::vector<WindowCommand>& asked);
    /// Whether there is room for all of it.
    static bool is_roomy(float width, float scale) { return width > 760 * scale; }

private:
    void draw_seek(const PanelFacts& facts, float scale, float room, std::vector<WindowCommand>& asked);

    float dragged_seconds_ = 0;
    bool dragging_ = false;
};

}  // namespace touchable
