#pragma once

namespace touchable {

/// Until that connection closes, its X server neither blanks the screen nor lets it sleep. Does nothing where
/// the server cannot be asked so (its extension MIT-SCREEN-SAVER), or the program was built without libXss.
/// `display`: Xlib's Display*.
void keep_screen_awake(void* display);

}  // namespace touchable
