#pragma once

#include <imgui.h>

#include <cstddef>
#include <string>
#include <vector>

namespace touchable {

// Rows of the panel, where Dear ImGui's cursor is. `scale` as in ScreenSize; less where there is little room.

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

/// While the pointer is over the button before: likewise, above its window, as high as `explanation_height`
/// with a gap. Gives whether it is.
bool explain_button(const char* words);
float explanation_height();

/// The typeface for words of that size, pixels: of the two that there are.
ImFont* font_of_size(float size);

/// A finger's colour, light enough to be told from the panel's dark ground.
ImU32 readable_finger_colour(std::size_t finger);

}  // namespace touchable
