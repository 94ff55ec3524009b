#pragma once

namespace touchable {

/// Over the picture of a window that nobody watches over: that it can be touched. `seconds` since it began to
/// show; the finger that shows how is drawn with the others. `held`: a device is there to touch it with.
/// Between ImGuiLayer's `begin` and `draw`.
void draw_invitation(double seconds, float width, float height, bool held);

/// All that it says, for whoever makes its letters.
const char* invitation_words();

}  // namespace touchable
