#pragma once

#include "player/window/panel_contents.hpp"

namespace touchable {

// Boxes in the corners of the window that only tell something, between ImGuiLayer's `begin` and `draw`.
// `scale` as in ScreenSize; sizes in pixels.

inline constexpr float panel_margin = 12, panel_bar_height = 48;

/// A box that stays where it is, of that size or as large as what is in it (0): ImGui::Begin. `flags`:
/// ImGuiWindowFlags besides.
struct FixedBox {
    float x = 0, y = 0;
    float pivot_x = 0, pivot_y = 0;  ///< the part of it that is there
    float width = 0, height = 0;
    int flags = 0;
    bool scrolls = false;  ///< what does not fit is scrolled to
};
void begin_box(const char* name, const FixedBox& box);

/// A bar for each finger, as high as its force, with lines at round newtons and a mark at the largest that
/// there may be. Upper left.
void draw_force(const PanelFacts& facts, float height, float scale);
/// What is under the pointer, but for what the bar or the panel covers. Lower left; a fifth of the window's
/// height and half of its width at most, which leaves the picture free: smaller words, and then fewer lines,
/// where it is small. Gives where something may end that lies above it.
float draw_place(const PanelFacts& facts, float width, float height, float scale);
/// What the surface's colours mean: a ramp with its ends, or a list. Lower right, so far from the edge.
void draw_overlay_scale(const OverlayScale& scale_of, float right, float bottom, float scale);

}  // namespace touchable
