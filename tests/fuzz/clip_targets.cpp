// Matroska clips: the file as a whole, and what their tags and blocks say.
#include <algorithm>
#include <cstdint>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/containers.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/input.hpp"
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
const Registered clip_target{{.name = "clip",
                              .parse = parse_clip,
                              .changes = 120,
                              .most_bytes = 12288,
                              .most_mebibytes = 2048,
                              .most_live_mebibytes = 2048}};
const Registered clip_tags_target{{.name = "clip_tags", .parse = parse_clip_tags, .most_bytes = 64}};
const Registered block_addition_target{
    {.name = "block_addition", .parse = parse_block_addition, .most_bytes = 256}};

}  // namespace
}  // namespace touchable::fuzz
