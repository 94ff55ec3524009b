#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "player/view/overlays.hpp"
#include "player/window/felt_panel.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The last values of something that is drawn as a curve.
class Curve {
public:
    explicit Curve(std::size_t values) : values_(values, 0.0F) {}
    void add(double value) {
        values_[next_] = static_cast<float>(value);
        next_ = (next_ + 1) % values_.size();
    }
    const std::vector<float>& values() const { return values_; }
    int begin() const { return static_cast<int>(next_); }

private:
    std::vector<float> values_;
    std::size_t next_ = 0;
};

/// Under the pointer, in words; empty where there is nothing to say.
struct PlaceFacts {
    std::vector<std::string> lines;
};

/// What the window's own words, bars and curves show.
struct PanelFacts {
    std::string clip;  ///< its name
    double seconds = 0, clip_seconds = 0;
    std::int64_t frame = 0;
    bool playing = true, looping = false, at_end = false;
    double speed = 1;
    std::string overlay;                  ///< of the surface's colours
    const OverlayScale* scale = nullptr;  ///< what those mean; null: they are the clip's own
    bool force_on = true;
    double pressed_mm = 0;       ///< how deep the finger is meant to be in the surface; below 0 above it
    std::vector<double> forces;  ///< newtons, by finger
    double most_newtons = 1;     ///< of the bar
    PlaceFacts place;
    FeltFacts felt;
    std::vector<std::string> figures;  ///< of the machine, a line each
    std::string message;               ///< of the moment: what a key did, or why a file cannot be opened
    bool message_is_bad = false;
    bool is_kiosk = false;            ///< only what a visitor needs
    std::optional<double> invited_s;  ///< since when it invites to touch, seconds; nothing: it does not
};

/// Dear ImGui's part of the window. What a person asks of it comes out as commands.
class WindowPanel {
public:
    explicit WindowPanel(double scale) : scale_(static_cast<float>(scale)), felt_(scale_) {}
    bool shown = false, help_shown = false;

    /// Between ImGuiLayer's `begin` and `draw`.
    void draw(const PanelFacts& facts, int width, int height, std::vector<WindowCommand>& asked);
    /// Whether something that can be pressed was there in the last picture.
    bool covers(double x, double y) const;
    /// Once a picture, whether it is drawn or not.
    void remember(const PanelFacts& facts, double frame_ms, double tick_us);

private:
    void draw_playback(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_force(const PanelFacts& facts, float height);
    void draw_place(const PanelFacts& facts, float height);
    void draw_side(const PanelFacts& facts, float width, float height, std::vector<WindowCommand>& asked);
    void draw_finger(const PanelFacts& facts, bool roomy, std::vector<WindowCommand>& asked);
    void draw_curves(const PanelFacts& facts);
    void draw_help(float width, float height);
    void draw_scale(const OverlayScale& scale, float width, float height);
    void draw_message(const PanelFacts& facts, float width);
    float side_width(float width) const;

    struct Box {
        float x0, y0, x1, y1;
    };
    void note_box();

    float scale_;
    std::vector<Box> boxes_;  // of what can be pressed
    FeltPanel felt_;
    Curve force_{300}, frame_ms_{300}, tick_us_{300};
    float dragged_seconds_ = 0;
    bool dragging_ = false;
};

}  // namespace touchable
