#pragma once

#include <string>
#include <vector>

#include "player/window/curves_panel.hpp"
#include "player/window/panel_contents.hpp"
#include "player/window/playback_bar.hpp"
#include "player/window/settings_panel.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// Dear ImGui's part of the window. What a person asks of it comes out as commands.
class WindowPanel {
public:
    /// `scale` as in ScreenSize.
    explicit WindowPanel(double scale) : scale_(static_cast<float>(scale)) {}
    void set_scale(double scale) { scale_ = static_cast<float>(scale); }
    bool shown = false, help_shown = false;
    bool bar_shown = true;  ///< where nothing else wants it

    /// Between ImGuiLayer's `begin` and `draw`.
    void draw(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked);
    /// Likewise where there is no clip yet: what is said, and what may be dropped.
    void draw_without_clip(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked);
    /// Whether something that can be pressed was there in the last picture.
    bool covers(double x, double y) const;
    /// Whether the bar is, or would be, there.
    bool is_bar(double x, double y) const { return bar_box_.has(x, y); }
    /// Once a picture, whether it is drawn or not.
    void remember(const PanelFacts& facts, double frame_ms, double tick_us);

private:
    void draw_side(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_title(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked);
    static void draw_view(float scale, std::vector<WindowCommand>& asked);
    void draw_finger(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked);
    void draw_kiosk(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_turn_back(const std::string& words, float width, std::vector<WindowCommand>& asked);
    void draw_state(const PanelFacts& facts, float width);
    void draw_message(const PanelFacts& facts, float width);
    void draw_fault(const PanelFacts& facts, float width, std::vector<WindowCommand>& asked);
    void draw_pointer(const PanelFacts& facts, float scale, std::vector<WindowCommand>& asked);
    void draw_hand(const HandFacts& hand, float scale);
    /// Between what the panel and the forces leave free of the width.
    struct Free {
        float from, to;
    };
    Free free_of(const PanelFacts& facts, float width) const;
    float side_width(float width) const;
    /// Whether the panel has its whole width.
    bool is_roomy(float width) const { return width > 760 * scale_; }

    struct Box {
        float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
        bool has(double x, double y) const {
            return x >= static_cast<double>(x0) && x < static_cast<double>(x1) &&
                   y >= static_cast<double>(y0) && y < static_cast<double>(y1);
        }
    };
    Box note_box();
    bool wants_bar(const PanelFacts& facts) const;

    float scale_;
    std::vector<Box> boxes_;  // of what can be pressed
    Box bar_box_;             // shown or not
    bool tool_was_held_ = false;
    float words_bottom_ = 0;  // of what is said above the picture; 0: nothing
    PlaybackBar bar_;
    SettingsPanel settings_;
    CurvesPanel curves_;
};

}  // namespace touchable
