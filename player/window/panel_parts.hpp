#pragma once

// What the window's panels are made of, each drawn where it is called (immediate mode): rows of the panel,
// where Dear ImGui's cursor is; boxes in the corners of the window, which take no clicks, between
// ImGuiLayer's `begin` and `draw`; lines over the picture, help, and the pages of a study and of an empty
// window. `scale` is ScreenSize's, or less in a small window; sizes are in pixels. By the window's thread.

#include <imgui.h>

#include <cstddef>
#include <string>
#include <vector>

#include "player/window/panel_facts.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The title of a part that a click folds away or out; whether it is out. `out`: at first.
bool draw_fold(const char* words, bool out);
/// Dim words, over as many lines as they take.
void draw_remark(const std::string& words);
/// What a row sets, on its left; the rest of it is for the next item.
void draw_label(const std::string& words, float scale);
/// With its value in words on its right. Whether it was moved; ImGui's last item is the slider.
bool draw_slider(const char* id, float& value, float least, float most, const std::string& words, float scale,
                 int flags = 0);
/// Words side by side, of which one holds (-1: none); which was clicked, or -1. `by_hand`: it was chosen in
/// the window.
int draw_words(const char* id, const std::vector<const char*>& words, int chosen, bool by_hand);
/// How wide an item may be that has its value in words on its right, and those words.
float value_column(float scale);
void draw_value(const char* words, float right_of, float top);

/// While the pointer is over the row before: what it is, in plain words, beside the panel.
void explain_row(const char* words);

/// While the pointer is over the button before: what it does, above its window, as high as
/// `explanation_height` with a gap. Gives whether it is.
bool explain_button(const char* words);
float explanation_height();

/// The typeface for words of that size, pixels: of the two that there are.
ImFont* font_of_size(float size);

/// A finger's colour, light enough to be told from the panel's dark ground.
ImU32 readable_finger_colour(std::size_t finger);

/// What a button shows that is drawn: no typeface is sure to have the signs.
enum class ButtonSign { none, play, pause, next, previous, home, touch, turn, colours };

/// In a square of that side, over ImGui's window.
void draw_sign(ButtonSign sign, const ImVec2& at, float side, ImU32 ink);

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
void draw_overlay_scale(const Overlays::Scale& scale_of, float right, float bottom, float scale);

/// What was measured, or begun with the brush, over the picture and below all panels.
void draw_measured_line(const MeasureFacts& facts, float scale);
void draw_brush_line(const BrushFacts& facts, float scale);

/// What keys, mouse and touch screen do, under titles.
struct HelpGroup {
    struct Row {
        std::string keys, what;
    };
    std::string title;
    std::vector<Row> rows;
};
/// All that does something now: by the list of keys (key_bindings), and the gestures beside them.
std::vector<HelpGroup> help_groups(const PanelFacts& facts);

/// In the middle, in two columns where the window is wide enough, as large as is legible; what does not fit
/// is scrolled to, and that it is there is said. Between ImGuiLayer's `begin` and `draw`; ImGui::End is the
/// caller's. `scale` as in ScreenSize; sizes in pixels.
void begin_help(const PanelFacts& facts, float width, float height, float scale);

/// Draws what may be dropped on a window without a clip, and where clips come from. Between ImGuiLayer's
/// `begin` and `end`; `scale` as in ScreenSize.
void draw_empty_page(float width, float height, float scale);

/// Says over the lower part of the picture, in large words, that forces of the mouse's fingers are off in a
/// window that is no kiosk. Between ImGuiLayer's `begin` and `end`.
void draw_stop(float width, float height);

/// What draw_stop and draw_empty_page write in the large size, whose letters the font has for them.
inline constexpr const char *stop_words = "Force is off", *go_on_words = "F brings it back",
                            *empty_page_title = "Drop a depth video here";

/// How high the strip is in which a participant of a study touches, in a window of that size.
float study_strip_height(float width, float height);

/// Draws the page or the strip of a study, and takes clicks: of an answer, and of the button. In an ImGui
/// window of its own, whose ImGui::End is the caller's. Between ImGuiLayer's `begin` and `end`; sizes in
/// pixels.
void begin_study(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked);

}  // namespace touchable
