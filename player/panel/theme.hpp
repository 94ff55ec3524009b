#pragma once

#include <string>

struct ImFont;

namespace touchable {

/// The current ImGui context's fonts, colours and distances; `scale` as in ScreenSize. Words are set in the
/// system's own sans-serif typeface where it has one.
void apply_theme(double scale);

/// The file of the system's usual typeface of this family; empty where there is none.
std::string font_file(const char* family);

}  // namespace touchable
