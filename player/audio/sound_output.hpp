#pragma once

#include <memory>
#include <string>
#include <thread>

#include "player/audio/heard_ticks.hpp"

namespace touchable {

/// The system's loudspeakers (ALSA's "default", which PipeWire and PulseAudio stand behind where they run),
/// on a thread of its own. Nobody waits for them, and nobody minds where there are none.
class SoundOutput {
public:
    /// Opens them at once, on that thread.
    explicit SoundOutput(std::shared_ptr<HeardTicks> ticks);
    /// What hangs in the system's sound is left behind, after a second.
    ~SoundOutput();
    SoundOutput(const SoundOutput&) = delete;
    SoundOutput& operator=(const SoundOutput&) = delete;

    /// "sound on", or why there is none. Any thread.
    std::string state() const;

    struct Shared;  ///< with the thread, which may outlive this

private:
    std::shared_ptr<Shared> shared_;
    std::thread thread_;
};

}  // namespace touchable
