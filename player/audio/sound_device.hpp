#pragma once

#include <chrono>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// Where samples at 48 kHz are heard: two channels of the system's own output. One thread's.
class SoundDevice {
public:
    static constexpr int buffer = 1920;  ///< samples that wait in it: 40 ms

    /// May take long where the system's sound does. Errors (ErrorKind::device) are a few words; so it is
    /// where the program was built without ALSA.
    static Result<std::unique_ptr<SoundDevice>> open();
    virtual ~SoundDevice() = default;
    /// Whether there is room for so many samples, after `longest` at most.
    virtual Result<bool> wait_for(int samples, std::chrono::milliseconds longest) = 0;
    virtual Result<void> write(std::span<const StereoSample> samples) = 0;
};

}  // namespace touchable
