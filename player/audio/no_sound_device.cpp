#include "player/audio/sound_device.hpp"

namespace touchable {

Result<std::unique_ptr<SoundDevice>> SoundDevice::open() {
    return Error{ErrorKind::device, "built without it (ALSA: libasound2-dev)"};
}

}  // namespace touchable
