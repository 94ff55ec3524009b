// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of the window's panels, drawn immediately (immediate mode): rows of the panel at Dear ImGui's cursor;
// boxes in the corners of the window, which take no clicks, between ImGuiLayer's `begin` and `draw`; lines
// over the picture, help, and the pages of a study and of an empty window. `scale` is ScreenSize's, or less
// in a small window; sizes are in pixels. The window's thread only.

#include <imgui.h>

#include <cstddef>
#include <string>
#include <vector>

#include "player/window/panel_facts.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

inline ImVec2 point_of(const glm::dvec2& at) {
    return {static_cast<float>(at.x), static_cast<float>(at.y)};
}

/// A section title that a click folds; returns whether it is open. `out`: initially open.
bool draw_fold(const char* words, bool out);
/// Dim text, wrapped.
void draw_remark(const std::string& words);
/// A row's label on the left; the next item gets the rest of the row.
void draw_label(const std::string& words, float scale);
/// A slider with its value as text on the right. Returns whether it was moved; it is ImGui's last item.
bool draw_slider(const char* id, float& value, float least, float most, const std::string& words, float scale,
                 int flags = 0);
/// Adjacent words, one of them chosen (-1: none); returns the clicked one, or -1. `by_hand`: chosen in the
/// window.
int draw_words(const char* id, const std::vector<const char*>& words, int chosen, bool by_hand);
/// Width of an item with its value as text on the right, and that text.
float value_column(float scale);
void draw_value(const char* words, float right_of, float top);

/// While the pointer is over the previous row: its explanation in plain words, beside the panel.
void explain_row(const char* words);

/// While the pointer is over the previous button: its explanation, above its window, with a height of
/// `explanation_height` and a gap. Returns whether it is shown.
bool explain_button(const char* words);
float explanation_height();

/// The better of the two fonts for text of that size, pixels.
ImFont* font_of_size(float size);

/// A finger's colour, lightened for the panel's dark background.
ImU32 readable_finger_colour(std::size_t finger);

/// A button's drawn sign: no typeface is sure to have them.
enum class ButtonSign { none, play, pause, next, previous, home, touch, turn, colours };

/// Draws in a square of that side, over ImGui's window.
void draw_sign(ButtonSign sign, const ImVec2& at, float side, ImU32 ink);

inline constexpr float panel_margin = 12, panel_bar_height = 48;

/// Begins a fixed box (ImGui::Begin), of that size, or as large as its content (0). `flags`: additional
/// ImGuiWindowFlags.
struct FixedBox {
    float x = 0, y = 0;
    float pivot_x = 0, pivot_y = 0;  ///< the point of the box at (x, y)
    float width = 0, height = 0;
    int flags = 0;
    bool scrolls = false;   ///< scrolls overflowing content
    bool has_keys = false;  ///< arrows, Space and Enter go through its items (WindowPanel::takes_keys)
};
void begin_box(const char* name, const FixedBox& box);

/// A bar for each finger, as high as its force, with lines at round newtons and a mark at the limit. Upper
/// left.
void draw_force(const PanelFacts& facts, float height, float scale);
/// The values at the pointer, unless the bar or the panel covers it. Lower left; at most a fifth of the
/// window's height and half of its width, to keep the picture free: smaller text, then fewer lines, if it is
/// small.
void draw_place(const PanelFacts& facts, float width, float height, float scale);
inline constexpr float widest_scale = 330;
/// The scale of the surface's colours: a ramp with its ends, or a list. Its lower right corner is given, and
/// its greatest width: below `widest_scale` it has smaller text.
void draw_overlay_scale(const Overlays::Scale& scale_of, float right, float bottom, float room, float scale);

/// The measured line, or the brush's unfinished one, over the picture and below all panels.
void draw_measured_line(const MeasureFacts& facts, float scale);
void draw_brush_line(const BrushFacts& facts, float scale);

/// The first key of a command, as keyboards print it; empty: it has none.
std::string keys_of(WindowVerb verb);
/// Help on keys, mouse and touch screen, in titled groups.
struct HelpGroup {
    struct Row {
        std::string keys, what;
    };
    std::string title;
    std::vector<Row> rows;
};
/// Help on all commands with an effect now: from the list of keys (key_bindings), and gestures.
std::vector<HelpGroup> help_groups(const PanelFacts& facts);

/// In the middle, in two columns if the window is wide enough, as large as is legible; overflowing text
/// scrolls, with a hint. Between ImGuiLayer's `begin` and `draw`; the caller calls ImGui::End. `scale` as in
/// ScreenSize; sizes in pixels.
void begin_help(const PanelFacts& facts, float width, float height, float scale);

/// Draws the page of a window without a clip: what may be dropped, and sources of clips unless there are so
/// many `recent` ones; returns the end of it. Between ImGuiLayer's `begin` and `end`; `scale` as in
/// ScreenSize.
float draw_empty_page(std::size_t recent, float width, float height, float scale);

/// Begins the box of files to choose from, as high as it needs; the caller calls ImGui::End.
void begin_files(const FileList& files, float top, float width, float bottom, float scale,
                 std::vector<WindowCommand>& asked);

/// Shows in large text over the lower part of the picture that forces of the mouse's fingers are off, except
/// in a kiosk. Between ImGuiLayer's `begin` and `end`.
void draw_stop(float width, float height);

/// Texts of draw_stop and draw_empty_page in the large size; the font has their letters.
inline constexpr const char *stop_words = "Force is off", *go_on_words = "F brings it back",
                            *empty_page_title = "Drop a depth video here";

/// Height of the strip shown while a study's participant touches, in a window of that size.
float study_strip_height(float width, float height);

/// Draws the page or the strip of a study, and takes clicks on answers and the button. In its own ImGui
/// window, whose ImGui::End the caller calls. Between ImGuiLayer's `begin` and `end`; sizes in pixels.
void begin_study(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked);

}  // namespace touchable
