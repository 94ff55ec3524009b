#pragma once

// The sound of a clip's file: decoded, or as it is stored.
//
// SoundTrack decodes to two channels at 48 kHz, from any number of channels at any rate, and seeks by sample;
// what is damaged is silent. A SoundPart names a stretch of another file's sound, which a clip takes along;
// StoredSound hands out its packets as they are stored, for a container that is written, and sound_of says
// which containers take them.
//
// Times count from the clip's first frame. A file without sound is no error of SoundTrack::open and sound_of,
// which may be asked of any file. Objects are one thread's each. Errors are lines about the file
// (ErrorKind::input).

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

/// The sound that a clip's file has beside its pictures, as two channels at 48 kHz. Sample 0 is heard with
/// the clip's first frame. One thread's.
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

/// The sound of another file as it is stored there, of a stretch of that file's pictures.
struct SoundPart {
    std::filesystem::path file;
    std::int64_t from_ns = 0;  ///< time 0 of the clip
    std::int64_t to_ns = 0;
};

/// The packets of a file's sound, as they are stored there. One thread's.
class StoredSound {
public:
    /// What a file has to be heard.
    struct Facts {
        std::string codec;                   ///< as FFmpeg names it
        bool storable = false;               ///< whether Matroska has it
        bool storable_in_mp4 = false;        ///< whether both have it
        bool storable_in_fragments = false;  ///< of MP4: whether its header needs no packet of it
    };

    /// Refused (ErrorKind::input) where the file has no sound that can be stored.
    static Result<std::unique_ptr<StoredSound>> open(const SoundPart& sound);
    virtual ~StoredSound() = default;

    virtual const AVCodecParameters& codec() const = 0;

    struct PacketDeleter {
        void operator()(AVPacket* packet) const;
    };
    using Packet = std::unique_ptr<AVPacket, PacketDeleter>;
    /// The next packet, times in milliseconds of the clip; null where it is heard later than `until_ms`, or
    /// there is none before the stretch ends.
    virtual Result<Packet> next(std::int64_t until_ms) = 0;
};

/// Nothing where the file has no sound, or is of no kind that could have any.
std::optional<StoredSound::Facts> sound_of(const std::filesystem::path& file);

}  // namespace touchable
