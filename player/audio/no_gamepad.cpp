#include "player/audio/gamepad.hpp"

namespace touchable {

Result<std::unique_ptr<Gamepad>> Gamepad::open() {
    return Error{ErrorKind::device, "built without it (SDL2: libsdl2-dev)"};
}

}  // namespace touchable
