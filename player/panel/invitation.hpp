#pragma once

namespace touchable {

/// Over the picture of a window that nobody watches over: that it can be touched. `seconds` since it began to
/// show; the finger that shows how is drawn with the others. `held`: a device is there to touch it with.
/// Between ImGuiLayer's `begin` and `draw`.
void draw_invitation(double seconds, float width, float height, bool held);

/// Over the picture of a window whose force is off, of the mouse's fingers: that, and what brings it back.
void draw_stop(float width, float height, bool is_kiosk);

/// All that they say, for whoever makes its letters.
const char* invitation_words();

}  // namespace touchable
