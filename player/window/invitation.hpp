#pragma once

#include "player/window/panel_contents.hpp"

namespace touchable {

/// Draws a kiosk's words over the lower part of its picture: an invitation to touch it, that forces of the
/// mouse's fingers are off and what brings them back (`is_stopped`), or a caption; the two last are in the
/// upper `room` of it. Whether there are any. (The finger that shows how is drawn with the others.) Between
/// ImGuiLayer's `begin` and `end`.
bool draw_kiosk_words(const KioskFacts& facts, bool is_stopped, float width, float height, float room);

/// Likewise while the forces of the mouse's fingers are off in a window that is no kiosk.
void draw_stop(float width, float height);

/// All words that these draw of their own, so that the font has their letters in the large size.
const char* invitation_words();

}  // namespace touchable
