#pragma once

#include <array>
#include <cstdint>

#include "player/audio/clip_sound.hpp"
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// The clip's sound at the clip's moments and speed: at half the speed an octave lower, as from a tape. Where
/// ticks and samples come by clocks that differ, it is played up to 0.3 % faster or slower; a jump in the
/// clip's time is a fade of a millisecond on each side.
class ClipVoice {
public:
    /// Adds the next millisecond.
    void add(const HeardTick& tick, ClipSound& sound, ContactSound::Samples& to);

    static constexpr double fastest = 8;

private:
    double step_to(const HeardTick& tick);

    double position_ = 0, volume_ = 0;  // samples of the clip; 0 to 1
    bool follows_ = false;
    std::uint64_t epoch_ = 0;
};

/// All that is heard: contacts, and the clip's own sound.
class HeardSound {
public:
    /// The next millisecond; samples are within -1 and 1.
    void render(const HeardTick& tick, ClipSound& clip, ContactSound::Samples& samples);

private:
    ContactSound contacts_;
    ClipVoice clip_;
};

}  // namespace touchable
