#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "engine/base/result.hpp"
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// A short sound, whole in memory: two channels of 16 bits at 48 kHz. Never changed.
struct SpokenSound {
    static constexpr double longest_s = 60;
    std::vector<std::array<std::int16_t, 2>> samples;

    /// Of any file whose sound FFmpeg decodes, such as a WAV file. Refused (ErrorKind::input): one without
    /// sound, or of more than `longest_s`.
    static Result<std::shared_ptr<const SpokenSound>> read(const std::filesystem::path& file);
};

/// Says one sound after the other, each from its begin; what is heard besides is softer meanwhile.
class SpokenVoice {
public:
    /// Adds the next millisecond to `to`. `sound` outlives it; null: none. `number`: another one begins it.
    void add(const SpokenSound* sound, std::uint32_t number, bool is_muted, ContactSound::Samples& to);

private:
    static constexpr float beside = 0.35F;  // of what is heard besides
    const SpokenSound* sound_ = nullptr;
    std::uint32_t number_ = 0;
    std::size_t next_ = 0;  // sample
    float volume_ = 0;      // of what is said
    float others_ = 1;      // of what is not
};

}  // namespace touchable
