#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/picture/stored_sound.hpp"

namespace touchable {

/// The sound of a file that is heard from its beginning again and again, as rounds of a loop begin. One
/// thread's.
class StreamSound {
public:
    /// Refused (ErrorKind::input) as by StoredSound.
    static Result<StreamSound> open(const SoundPart& sound);

    const AVCodecParameters& codec() const { return sound_->codec(); }
    /// The next packet, times in milliseconds of the stream; null where it is heard later than `until_ms`.
    Result<StoredSound::Packet> next(std::int64_t until_ms);
    /// What was not heard by now is left out, and the sound begins anew at `at_ms` of the stream.
    Result<void> begin_round(std::int64_t at_ms);

private:
    StreamSound(const SoundPart& part, std::unique_ptr<StoredSound> sound)
        : part_(part), sound_(std::move(sound)) {}

    SoundPart part_;
    std::unique_ptr<StoredSound> sound_;
    std::int64_t begin_ms_ = 0;
};

}  // namespace touchable
