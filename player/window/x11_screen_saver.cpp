#include <X11/extensions/scrnsaver.h>

#include "player/window/screen_saver.hpp"

namespace touchable {

void keep_screen_awake(void* display) {
    auto* const server = static_cast<Display*>(display);
    int first_event = 0, first_error = 0;
    if (XScreenSaverQueryExtension(server, &first_event, &first_error) == 0) return;
    XScreenSaverSuspend(server, True);
    XFlush(server);
}

}  // namespace touchable
