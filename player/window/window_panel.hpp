// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "player/view/pointer.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The last values of a quantity that is drawn as a curve.
class Curve {
public:
    static constexpr std::size_t most = 240;  // values
    void add(double value) {
        values_[next_] = static_cast<float>(value);
        next_ = (next_ + 1) % most;
    }
    /// The k-th, oldest first.
    float operator[](std::size_t k) const { return values_[(next_ + k) % most]; }
    float newest() const { return values_[(next_ + most - 1) % most]; }
    float greatest() const;

private:
    std::array<float, most> values_{};
    std::size_t next_ = 0;
};

/// Curves over the last pictures: each finger's force, the times of a picture and a tick, and late ticks and
/// dropped frames.
class CurvesPanel {
public:
    /// Once a picture, whether or not the curves are drawn.
    void remember(const PanelFacts& facts, double picture_ms, double tick_us);
    /// Draws at Dear ImGui's cursor. `most_newtons`: the force limit; `scale` as in ScreenSize.
    void draw(double most_newtons, float scale);

private:
    std::array<Curve, PointerFingers::most> forces_;
    Curve picture_ms_, tick_us_, late_ticks_, dropped_frames_;
    std::int64_t all_late_ = 0, all_dropped_ = 0;
};

/// The bar below: play, time, seek, and buttons for users without keys. Buttons are dropped, the least needed
/// first, until the seek bar has a minimum width.
class PlaybackBar {
public:
    /// `scale` as in ScreenSize. Call between begin_box and ImGui::End. `panel_shown`, `help_shown`: states
    /// for their buttons.
    void draw(const PanelFacts& facts, float width, float height, float scale, bool panel_shown,
              bool help_shown, std::vector<WindowCommand>& asked);

    /// Whether a button's tooltip is shown, above the bar.
    bool explains() const { return explains_; }

private:
    void draw_seek(const PanelFacts& facts, float scale, float room, std::vector<WindowCommand>& asked);

    float dragged_seconds_ = 0;
    bool dragging_ = false, explains_ = false;
};

/// The panel's rows for settings of touch, at Dear ImGui's cursor. `scale` as in panel_parts.hpp.
class SettingsPanel {
public:
    /// `of`: felt (which includes a device's), filters or relief.
    void draw(SettingOf of, const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked);

private:
    void draw_row(const SessionSetting& setting, const SettingsFacts& facts,
                  std::vector<WindowCommand>& asked);
    void draw_number(const SessionSetting& setting, const SettingsFacts& facts,
                     std::vector<WindowCommand>& asked);

    float scale_ = 1;
    std::string held_;   // name of the dragged slider
    float dragged_ = 0;  // its value
};

/// Dear ImGui's part of the window. User requests are returned as commands.
class WindowPanel {
public:
    /// `scale` as in ScreenSize.
    explicit WindowPanel(double scale = 1) : scale_(static_cast<float>(scale)) {}
    void set_scale(double scale) { scale_ = static_cast<float>(scale); }
    bool shown = false, help_shown = false;
    bool has_focus = false;             ///< the panel has the keys
    std::optional<glm::dvec2> menu_at;  ///< window, pixels; nullopt: no menu
    /// Shows or hides the panel. `by_key`: it gets the keys, even if it was shown.
    void turn_over(bool by_key) {
        has_focus = by_key && !(shown && has_focus);
        shown = by_key ? has_focus : !shown;
    }
    /// Closes the menu, or gives the keys back; returns whether there was something.
    bool leave() { return std::exchange(menu_at, std::nullopt) || std::exchange(has_focus, false); }
    bool hidden = false;    ///< all but messages and what lies on the surface
    bool silent = false;    ///< hides messages too while `hidden`
    bool bar_shown = true;  ///< unless something else needs it
    /// Whether a list takes this key, to go through its items.
    bool takes_key(const InputEvent& event) const;

    /// Call between ImGuiLayer's `begin` and `draw`.
    void draw(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked);
    /// The same without a clip: messages, and what may be dropped.
    void draw_without_clip(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked);
    /// Whether the last picture had a clickable item there.
    bool covers(const glm::dvec2& at) const {
        return std::ranges::any_of(boxes_, [&at](const Box& box) { return box.has(at); });
    }
    /// Whether the bar covers the point when shown.
    bool is_bar(const glm::dvec2& at) const { return bar_box_.has(at); }
    /// Whether a widget is being pressed or dragged.
    bool holds_pointer() const;
    /// Width that the panel takes from the picture, pixels: 0 where it lies over it.
    float aside(float width) const;
    /// Once a picture, whether or not the panel is drawn.
    void remember(const PanelFacts& facts, double picture_ms, double tick_us) {
        curves_.remember(facts, picture_ms, tick_us);
    }

private:
    void draw_menu(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_side(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_kiosk(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_turn_back(const std::string& words, float width, std::vector<WindowCommand>& asked);
    void draw_state(const PanelFacts& facts, float width);
    void draw_message(const PanelFacts& facts, float width, float height);
    void draw_fault(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    /// The place of the next words above the picture, between the forces and the panel: the middle of its
    /// upper edge, the width there, and the width at which messages wrap.
    struct Free {
        float middle, top, width, wrap;
    };
    Free free_of(const PanelFacts& facts, float width) const;
    float side_width(float width) const;
    /// Whether there is room for the panel's full width.
    bool is_roomy(float width) const { return width > 760 * scale_; }

    struct Box {
        float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
        bool has(const glm::dvec2& at) const {
            return at.x >= static_cast<double>(x0) && at.x < static_cast<double>(x1) &&
                   at.y >= static_cast<double>(y0) && at.y < static_cast<double>(y1);
        }
    };
    Box note_box();
    void lead_keys(bool into_a_list);
    bool draw_page(const PanelFacts& facts, float top, float width, float height,
                   std::vector<WindowCommand>& asked);
    /// Also shown beside the panel, and at the end, where it is used to continue.
    bool wants_bar(const PanelFacts& facts) const {
        return bar_shown || shown || help_shown || (facts.at_end && facts.last_seconds > 0);
    }

    float scale_;
    std::vector<Box> boxes_;  // of clickable items
    Box bar_box_;             // shown or hidden
    bool tool_was_held_ = false, has_keys_ = false;
    float words_bottom_ = 0;  // lower edge of messages above the picture; 0: none
    PlaybackBar bar_;
    SettingsPanel settings_;
    CurvesPanel curves_;
};

}  // namespace touchable
