#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "player/window/panel_facts.hpp"
#include "player/window/pointer.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The last values of something that is drawn as a curve.
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

/// Curves over the last pictures: each finger's force, the time that a picture and a tick take, and ticks and
/// frames that came too late.
class CurvesPanel {
public:
    /// Once a picture, whether it is drawn or not.
    void remember(const PanelFacts& facts, double picture_ms, double tick_us);
    /// Where Dear ImGui's cursor is. `most_newtons`: of the highest force; `scale` as in ScreenSize.
    void draw(double most_newtons, float scale);

private:
    std::array<Curve, PointerFingers::most> forces_;
    Curve picture_ms_, tick_us_, late_ticks_, dropped_frames_;
    std::int64_t all_late_ = 0, all_dropped_ = 0;
};

/// The bar below: play, time, seek, and a button for each thing that a person without keys looks for. Of
/// those there are as many as leave the seek bar some width; the most needed stay longest.
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

/// The panel's parts for the settings of what is felt, a row each, where Dear ImGui's cursor is. `scale` as
/// in panel_parts.hpp.
class SettingsPanel {
public:
    /// `of`: felt, of which a device's are a part, filters or relief.
    void draw(SettingOf of, const SettingsFacts& facts, float scale, std::vector<WindowCommand>& asked);

private:
    void draw_row(const SessionSetting& setting, const SettingsFacts& facts,
                  std::vector<WindowCommand>& asked);
    void draw_number(const SessionSetting& setting, const SettingsFacts& facts,
                     std::vector<WindowCommand>& asked);

    float scale_ = 1;
    std::string held_;   // the slider that is dragged
    float dragged_ = 0;  // what it says
};

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
    /// The same without a clip: what is said, and what may be dropped.
    void draw_without_clip(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked);
    /// Whether something that can be pressed was there in the last picture.
    bool covers(double x, double y) const {
        return std::ranges::any_of(boxes_, [x, y](const Box& box) { return box.has(x, y); });
    }
    /// Whether the bar is, or would be, there.
    bool is_bar(double x, double y) const { return bar_box_.has(x, y); }
    /// Once a picture, whether it is drawn or not.
    void remember(const PanelFacts& facts, double picture_ms, double tick_us) {
        curves_.remember(facts, picture_ms, tick_us);
    }

private:
    void draw_side(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_kiosk(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_turn_back(const std::string& words, float width, std::vector<WindowCommand>& asked);
    void draw_state(const PanelFacts& facts, float width);
    void draw_message(const PanelFacts& facts, float width);
    void draw_fault(const PanelFacts& facts, float width, std::vector<WindowCommand>& asked);
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
    /// Beside what is set in the panel; and at the end, where it is what goes on.
    bool wants_bar(const PanelFacts& facts) const {
        return bar_shown || shown || help_shown || (facts.at_end && facts.last_seconds > 0);
    }

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
