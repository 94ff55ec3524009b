// The sound that a clip's file has beside its pictures, by FFmpeg's demuxers and decoders.
#include <array>
#include <cmath>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// As it is kept in another file, where it can be.
void require_packets(const std::filesystem::path& file) {
    constexpr int most_packets = 16;
    const auto facts = sound_of(file);
    if (!facts || !facts->storable) return;
    SoundPart part;
    part.file = file;
    const auto stored = StoredSound::open(part);
    if (!is_taken(stored)) return;
    for (int k = 0; k < most_packets; ++k) {
        const auto packet = (*stored)->next(10'000);
        if (!is_taken(packet) || !*packet) return;
        require((*packet)->size >= 0, "a packet has fewer bytes than none");
    }
}

/// From its beginning, from a place in it, and far behind it.
bool parse_sound(std::string_view bytes) {
    const auto file = file_of(bytes, "sound");
    require_packets(file);
    const auto opened = SoundTrack::open(file);
    if (!is_taken(opened) || !*opened) return false;
    SoundTrack& track = **opened;
    std::array<StereoSample, 2048> samples;
    bool is_heard = false;
    for (const std::int64_t begin : {std::int64_t{0}, std::int64_t{300}, std::int64_t{1} << 40}) {
        track.seek(begin);
        samples.fill({std::nanf(""), std::nanf("")});
        track.read(samples);
        for (const StereoSample& sample : samples) {
            require(!std::isnan(sample.left) && !std::isnan(sample.right), "a sample is no number");
            is_heard = is_heard || sample.left != 0;
        }
    }
    return is_heard && !track.is_damaged();
}

const Registered sound_target{
    {.name = "sound", .parse = parse_sound, .changes = 150, .most_live_mebibytes = 512}};

}  // namespace
}  // namespace touchable::fuzz
