#pragma once

#include <vector>

#include "player/window/panel_contents.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The bar below: play, time, seek, and a button for whatever somebody without keys looks for. Of those there
/// are as many as leave the seek bar some width; the most needed stay longest.
class PlaybackBar {
public:
    /// `scale` as in ScreenSize. Between begin_box and ImGui::End. `panel_shown`, `help_shown`: whether they
    /// are, for their buttons.
    void draw(const PanelFacts& facts, float width, float height, float scale, bool panel_shown,
              bool help_shown, std::vector<WindowCommand>& asked);

    /// Whether a button is explained, above the bar.
    bool explains() const { return explains_; }

private:
    void draw_seek(const PanelFacts& facts, float scale, float room, std::vector<WindowCommand>& asked);

    float dragged_seconds_ = 0;
    bool dragging_ = false, explains_ = false;
};

}  // namespace touchable
