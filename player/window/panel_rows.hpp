#pragma once

#include <string>
#include <vector>

namespace touchable {

// Rows of the panel, where Dear ImGui's cursor is. `scale` as in ScreenSize.

/// A title of a part of the panel.
void draw_heading(const char* words);
/// Dim, as long as it takes.
void draw_remark(const std::string& words);
/// What a row sets, on its left; the rest of it is for the next item.
void draw_label(const std::string& words, float scale);
/// With its value in words on its right. Whether it was moved; ImGui's last item is the slider.
bool draw_slider(const char* id, float& value, float least, float most, const std::string& words, float scale,
                 int flags = 0);
/// Words side by side, of which one holds (-1: none); which was clicked, or -1. `by_hand`: it was chosen in
/// the window.
int draw_words(const char* id, const std::vector<const char*>& words, int chosen, bool by_hand);

}  // namespace touchable
