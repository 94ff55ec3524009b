#pragma once

namespace touchable {

/// Draws words over a kiosk's picture that invite to touch it. `seconds`: since they began to show. (The
/// finger that shows how is drawn with the others.) `held`: a device is there to touch it with. Between
/// ImGuiLayer's `begin` and `draw`.
void draw_invitation(double seconds, float width, float height, bool held);

/// Draws words over the picture while the forces of the mouse's fingers are off: that they are, and what
/// turns them on again.
void draw_stop(float width, float height, bool is_kiosk);

/// All words that these draw, so that the font has their letters in the large size.
const char* invitation_words();

}  // namespace touchable
