// SPDX-License-Identifier: Apache-2.0
// Matroska clips: the file as a whole, and what their tags and blocks say.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/containers.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/touch_maps.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/input.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/scene.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// Its container alone: what FFmpeg does not look at.
bool parse_container(std::string_view bytes) {
    const auto file = file_of(bytes, "container.mkv");
    const auto source = bytes_of_file(file);
    return source && is_taken(check_matroska(**source, file.string()));
}

bool parse_clip(std::string_view bytes) {
    return is_clip(open_matroska_clip(file_of(bytes, "clip.mkv"), std::nullopt));
}

bool parse_clip_tags(std::string_view bytes) {
    const auto version = clip_tags::parse_version(bytes);
    require(!version || *version >= 1, "a version below 1");
    const auto bits = clip_tags::parse_bits(bytes);
    require(!bits || (*bits >= 9 && *bits <= 16), "bits that a tag cannot have");
    const auto rate = clip_tags::parse_rate(bytes);
    if (rate) {
        require(rate->num > 0 && rate->den > 0, "a rate is not above 0");
        const auto again = clip_tags::parse_rate(clip_tags::rate_text(*rate));
        require(again && clip_tags::same_rate(*rate, *again), "a rate is another when it is read again");
        (void)clip_tags::is_too_fast(*rate);
    }
    return version || bits || rate;
}

/// A packet's addition as it stands, and one of the packet's own. The first byte: how many are the
/// addition's.
bool parse_block_addition(std::string_view bytes) {
    Taken taken(bytes);
    const std::size_t size = taken.byte() % 24;
    const std::string_view addition = taken.rest().substr(0, size),
                           payload = taken.rest().substr(addition.size());
    const PacketPtr packet(av_packet_alloc());
    if (av_new_packet(packet.get(), static_cast<int>(payload.size())) < 0) return false;
    std::copy(payload.begin(), payload.end(), packet->data);
    std::uint8_t* const said =
        av_packet_new_side_data(packet.get(), AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, addition.size());
    std::copy(addition.begin(), addition.end(), said);
    const auto found = block_addition_of(*packet);
    require(found.has_value(), "an addition is not found");
    require(!found->sound || (found->frames >= 1 && found->frames <= clip_tags::access_interval),
            "a picture stays for an impossible time");
    av_packet_free_side_data(packet.get());
    require(bool(add_block_addition(*packet, AV_CODEC_ID_FFV1, 7)), "no memory");
    const auto own = block_addition_of(*packet);
    require(own && own->sound && own->frames == 7, "an addition does not come back");
    return found->sound;
}

const Registered container_target{{.name = "container", .parse = parse_container, .most_bytes = 8192}};
const Registered clip_target{
    {.name = "clip", .parse = parse_clip, .changes = 120, .most_bytes = 12288, .decodes_video = true}};
const Registered clip_tags_target{{.name = "clip_tags", .parse = parse_clip_tags, .most_bytes = 64}};
const Registered block_addition_target{
    {.name = "block_addition", .parse = parse_block_addition, .most_bytes = 256}};

// Any file that a user opens.

/// Opened as it is, and with a camera that is known. Without an ending: its first bytes tell.
bool parse_any_file(std::string_view bytes) {
    const auto file = file_of(bytes, "input");
    const bool taken = is_clip(open_clip(file));
    SourceDescription known;
    known.fov = 60;
    known.metres_per_code = 0.001;
    (void)is_clip(open_clip(file, std::nullopt, known));
    return taken;
}

/// An archive of pictures, which is unpacked.
bool parse_zip(std::string_view bytes) {
    return is_clip(open_clip(file_of(bytes, "pictures.zip")));
}

/// A video of depth as others write them, whose demuxers and decoders are FFmpeg's.
bool parse_video(std::string_view bytes) {
    return is_clip(open_clip(file_of(bytes, "video.mp4")));
}

const Registered any_file_target{
    {.name = "any_file", .parse = parse_any_file, .changes = 100, .decodes_video = true}};
const Registered zip_folder_target{{.name = "zip_folder",
                                    .parse = parse_zip,
                                    .cuts_are_refused = true,
                                    .changes = 100,
                                    .decodes_video = true}};
const Registered video_target{
    {.name = "video", .parse = parse_video, .changes = 90, .most_bytes = 8192, .decodes_video = true}};

// Maps of touch in the files of other programs, and clips as glTF scenes.

bool is_haptic_map(const std::filesystem::path& file) {
    Scene scene = parse_scene(R"({"touchable_scene": 1, "width": 8, "height": 6,
        "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2}, "depth": {"coding": "linear", "near": 1, "far": 2}})",
                              "scene.json")
                      ->scene;
    const auto map = read_haptic_map(file, scene);
    if (!is_taken(map)) return false;
    const PlaneView& view = map->plane.view;
    require(view.width > 0 && view.height > 0 && view.bytes_per_sample == 1, "a map is no picture");
    (void)view.sample(view.width - 1, view.height - 1, view.channels - 1);
    for (const std::string& note : map->notes) require(!note.empty(), "a note says nothing");
    return true;
}

bool parse_x3d(std::string_view bytes) {
    return is_haptic_map(file_of(bytes, "surface.x3d"));
}
bool parse_gltf(std::string_view bytes) {
    return is_haptic_map(file_of(bytes, "material.gltf"));
}

/// Beside a picture of depth and one of touch, and a clip in MP4.
bool parse_gltf_clip(std::string_view bytes) {
    static const bool is_ready = [] {
        constexpr int side = 16;  // as the clip's
        const std::vector<std::uint8_t> samples(std::size_t{side} * side * 3, 200);
        const auto put = [&](const char* name, int channels) {
            const PlaneView plane{samples.data(), std::ptrdiff_t{side} * channels, side, side, 1, channels};
            return bool(write_png(file_of("", name), plane));
        };
        const Target seeds{.name = "mp4_clip", .parse = nullptr};
        file_of(seeds_of(seeds).front().bytes, "planes.mp4");
        return put("depth.png", 1) && put("touch.png", 3);
    }();
    require(is_ready, "the files beside it cannot be written");
    return is_clip(open_gltf_clip({file_of(bytes, "clip.gltf")}));
}

const Registered x3d_target{{.name = "x3d", .parse = parse_x3d}};
const Registered gltf_target{{.name = "gltf", .parse = parse_gltf}};
const Registered gltf_clip_target{{.name = "gltf_clip",
                                   .parse = parse_gltf_clip,
                                   .cuts_are_refused = true,
                                   .needless_bytes = 1,
                                   .decodes_video = true}};

// The sound that a clip's file has beside its pictures, by FFmpeg's demuxers and decoders.

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

// Packets of our own codec, of both versions: two bytes of size, then the packet; and the same bytes as a
// picture.

using Version = RankZstdDecoder::Version;

struct CodedPicture {
    int width, height;
    std::vector<std::uint16_t> samples;

    bool is_decoded(RankZstdDecoder& decoder, std::span<const std::uint8_t> packet) {
        return decoder.decode(packet, width, height, samples.data(), width);
    }
};

/// A picture's packet is decoded to the picture, whatever was encoded and decoded before.
void require_round_trip(RankEncoder& encoder, RankZstdDecoder& decoder, const CodedPicture& picture,
                        bool choose) {
    const auto* const data = reinterpret_cast<const std::uint8_t*>(picture.samples.data());
    const auto packet = encoder.encode(
        {data, std::ptrdiff_t{2} * picture.width, picture.width, picture.height, 2, 1}, choose);
    CodedPicture again = picture;
    std::ranges::fill(again.samples, std::uint16_t{0});
    require(decoder.promises(packet, picture.samples.size()), "a packet does not promise its picture");
    require(again.is_decoded(decoder, packet), "a packet is not decoded");
    require(again.samples == picture.samples, "a picture comes back another");
    if (packet[0] != 0) return;
    RankZstdDecoder first(Version::first);
    require(again.is_decoded(first, packet.subspan(1)), "mode 0 is not the first version's");
    require(again.samples == picture.samples, "the first version has another picture");
}

bool parse_packet(std::string_view bytes, Version version) {
    Taken taken(bytes);
    CodedPicture picture{
        static_cast<int>(taken.byte() % 64) + 1, static_cast<int>(taken.byte() % 64) + 1, {}};
    picture.samples.resize(static_cast<std::size_t>(picture.width) *
                           static_cast<std::size_t>(picture.height));
    const std::string_view rest = taken.rest();
    const std::span packet(reinterpret_cast<const std::uint8_t*>(rest.data()), rest.size());
    RankZstdDecoder decoder(version), second(Version::second);
    const bool is_decoded = picture.is_decoded(decoder, packet);
    if (is_decoded)
        require(decoder.promises(packet, picture.samples.size()), "a packet held what it did not promise");
    RankEncoder encoder(zstd_at(1));
    require_round_trip(encoder, second, picture, true);
    if (!rest.empty()) {
        const std::size_t size = 2 * picture.samples.size();
        std::memcpy(picture.samples.data(), rest.data(), std::min(rest.size(), size));
    }
    require_round_trip(encoder, second, picture, false);
    return is_decoded;
}

const Registered gradient_zstd_target{
    {.name = "gradient_zstd",
     .parse = [](std::string_view bytes) { return parse_packet(bytes, Version::first); },
     .cuts_are_refused = true}};
const Registered rank_zstd_target{
    {.name = "rank_zstd",
     .parse = [](std::string_view bytes) { return parse_packet(bytes, Version::second); },
     .cuts_are_refused = true}};

}  // namespace
}  // namespace touchable::fuzz
