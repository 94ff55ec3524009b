#include "player/window/touch_screen.hpp"

namespace touchable {

Result<std::unique_ptr<TouchScreen>> TouchScreen::open(unsigned long) {
    return Error{ErrorKind::device, "built without it (XInput2: libxi-dev)"};
}

}  // namespace touchable
