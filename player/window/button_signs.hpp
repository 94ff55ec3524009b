#pragma once

#include <imgui.h>

namespace touchable {

/// What a button shows that is drawn: no typeface is sure to have the signs.
enum class ButtonSign { none, play, pause, next, previous, home, touch, turn, colours };

/// In a square of that side, over ImGui's window.
void draw_sign(ButtonSign sign, const ImVec2& at, float side, ImU32 ink);

}  // namespace touchable
