#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"

struct AVCodecParameters;
struct AVPacket;

namespace touchable {

/// What a file has to be heard.
struct SoundFacts {
    std::string codec;                   ///< as FFmpeg names it
    bool storable = false;               ///< whether Matroska has it
    bool storable_in_mp4 = false;        ///< whether both have it
    bool storable_in_fragments = false;  ///< of MP4: whether its header needs no packet of it
};
/// Nothing where the file has no sound, or is of no kind that could have any.
std::optional<SoundFacts> sound_of(const std::filesystem::path& file);

/// The sound of another file as it is stored there, of a stretch of that file's pictures.
struct SoundPart {
    std::filesystem::path file;
    std::int64_t from_ns = 0;  ///< time 0 of the clip
    std::int64_t to_ns = 0;
};

/// The packets of a file's sound, as they are stored there. One thread's.
class StoredSound {
public:
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

}  // namespace touchable
