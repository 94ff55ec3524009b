#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "engine/base/result.hpp"

namespace touchable {

struct StereoSample {
    float left = 0, right = 0;
};

/// The sound that a clip's file has beside its pictures, as two channels at 48 kHz, whatever it is stored as.
/// Sample 0 is heard with the clip's first frame. One thread's.
class SoundTrack {
public:
    static constexpr int rate = 48'000;

    /// Null where the file has no sound, or is none of a kind that could (a folder, a picture, an archive).
    /// Errors (ErrorKind::input) where it has, and nothing can decode it.
    static Result<std::unique_ptr<SoundTrack>> open(const std::filesystem::path& file);
    virtual ~SoundTrack() = default;

    /// What is read next begins with this sample.
    virtual void seek(std::int64_t sample) = 0;
    /// Fills `to` with what follows. What is damaged, before the track's begin or after its end is silence.
    virtual void read(std::span<StereoSample> to) = 0;
    /// Whether any of what was read so far is silent because it is damaged.
    virtual bool is_damaged() const = 0;
};

}  // namespace touchable
