// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sound of a clip's file: decoded, or as it is stored.
//
// SoundTrack decodes to two channels at 48 kHz, from any number of channels at any rate, and seeks by sample;
// damaged parts are silent. A SoundPart names a stretch of another file's sound, which a clip takes along;
// StoredSound hands out its packets as they are stored, for a container that is written, and sound_of says
// which containers take them.
//
// Times count from the clip's first frame. SoundTrack::open and sound_of take any file: one without sound is
// no error. Errors are lines about the file (ErrorKind::input).
// Threads: one uses an object.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "engine/base/result.hpp"

struct AVCodecParameters;
struct AVPacket;

namespace touchable {

struct StereoSample {
    float left = 0, right = 0;
};
/// A sample of any values as integers: left and right.
std::array<std::int16_t, 2> in_16_bits(const StereoSample& sample);

/// The sound that a clip's file has beside its pictures, as two channels at 48 kHz. Sample 0 is heard with
/// the clip's first frame. Used by one thread.
class SoundTrack {
public:
    static constexpr int rate = 48'000;

    /// Null if the file has no sound, or is of a kind without any (a folder, a picture, an archive). An error
    /// (ErrorKind::input) if its sound cannot be decoded.
    static Result<std::unique_ptr<SoundTrack>> open(const std::filesystem::path& file);
    virtual ~SoundTrack() = default;

    /// Makes `read` go on from this sample.
    virtual void seek(std::int64_t sample) = 0;
    /// Fills `to` with the next samples. Damaged parts, and those before or after the track, are silent.
    virtual void read(std::span<StereoSample> to) = 0;
    /// Whether anything read so far is silent because of damage.
    virtual bool is_damaged() const = 0;
};

/// A stretch of another file's sound, as stored there; times are those of that file's pictures.
struct SoundPart {
    std::filesystem::path file;
    std::int64_t from_ns = 0;  ///< time 0 of the clip
    std::int64_t to_ns = 0;
};

/// The packets of a file's sound, as they are stored there. Used by one thread.
class StoredSound {
public:
    /// Facts about a file's sound.
    struct Facts {
        std::string codec;                   ///< as FFmpeg names it
        bool storable = false;               ///< Matroska can hold it
        bool storable_in_mp4 = false;        ///< MP4 can hold it, too
        bool storable_in_fragments = false;  ///< so can MP4 in fragments: its header needs no packet
    };

    /// Refused (ErrorKind::input) if the file has no sound that can be stored.
    static Result<std::unique_ptr<StoredSound>> open(const SoundPart& sound);
    virtual ~StoredSound() = default;

    virtual const AVCodecParameters& codec() const = 0;

    struct PacketDeleter {
        void operator()(AVPacket* packet) const;
    };
    using Packet = std::unique_ptr<AVPacket, PacketDeleter>;
    /// The next packet, times in milliseconds of the clip; null if it is heard later than `until_ms`, or the
    /// stretch has ended.
    virtual Result<Packet> next(std::int64_t until_ms) = 0;
};

/// Nullopt if the file has no sound, or is of a kind without any.
std::optional<StoredSound::Facts> sound_of(const std::filesystem::path& file);

}  // namespace touchable
