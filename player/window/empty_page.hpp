#pragma once

namespace touchable {

/// Draws what may be dropped on a window without a clip, and where clips come from. Between ImGuiLayer's
/// `begin` and `end`; `scale` as in ScreenSize.
void draw_empty_page(float width, float height, float scale);

/// What it draws in the large size.
const char* empty_page_title();

}  // namespace touchable
