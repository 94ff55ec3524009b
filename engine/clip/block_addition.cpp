#include "engine/clip/block_addition.hpp"

#include <span>

#include "engine/clip/clip_tags.hpp"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

// Identifier of the addition (8 bytes, FFmpeg's), frames (4), CRC-32 (4); in a stream, the number of the
// frame (8) and when it was taken (8). All with the high byte first.
constexpr std::size_t frames_at = 8, crc_at = 12, addition_size = 16, label_at = 16, labelled_size = 32;
constexpr std::uint64_t addition_id = 1;

std::uint32_t crc_of(std::uint32_t crc, const std::uint8_t* bytes, std::size_t size) {
    return av_crc(av_crc_get_table(AV_CRC_32_IEEE), crc, bytes, size);
}

constexpr std::uint32_t crc_of_nothing = ~std::uint32_t{0};

/// The next 00 00 01 from `at` on, or the end.
std::size_t start_code(std::span<const std::uint8_t> bytes, std::size_t at) {
    for (; at + 3 <= bytes.size(); ++at)
        if (bytes[at] == 0 && bytes[at + 1] == 0 && bytes[at + 2] == 1) return at;
    return bytes.size();
}

/// Matroska has a length before each unit of H.264 where its encoder has a start code (ISO/IEC 14496-15; one
/// of four bytes begins with a zero more).
std::uint32_t crc_of_units(std::uint32_t crc, std::span<const std::uint8_t> bytes) {
    std::size_t begin = start_code(bytes, 0);
    while (begin < bytes.size()) {
        begin += 3;
        const std::size_t next = start_code(bytes, begin);
        const std::size_t end = next < bytes.size() && bytes[next - 1] == 0 ? next - 1 : next;
        std::uint8_t length[4];
        AV_WB32(length, static_cast<std::uint32_t>(end - begin));
        crc = crc_of(crc, length, sizeof length);
        crc = crc_of(crc, bytes.data() + begin, end - begin);
        begin = next;
    }
    return crc;
}

std::uint32_t crc_of_addition(std::span<const std::uint8_t> addition) {
    const std::uint32_t crc = crc_of(crc_of_nothing, addition.data() + frames_at, 4);
    return crc_of(crc, addition.data() + label_at, addition.size() - label_at);
}

}  // namespace

Result<void> add_block_addition(AVPacket& packet, AVCodecID codec, std::int64_t frames,
                                const std::optional<PictureLabel>& label) {
    const std::size_t size = label ? labelled_size : addition_size;
    std::uint8_t* data = av_packet_new_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, size);
    if (!data) return Error{ErrorKind::internal, "out of memory"};
    AV_WB64(data, addition_id);
    AV_WB32(data + frames_at, static_cast<std::uint32_t>(frames));
    if (label) {
        AV_WB64(data + label_at, static_cast<std::uint64_t>(label->frame));
        AV_WB64(data + label_at + 8, static_cast<std::uint64_t>(label->taken_ns));
    }
    const std::uint32_t crc = crc_of_addition(std::span(data, size));
    const std::span<const std::uint8_t> bytes(packet.data, static_cast<std::size_t>(packet.size));
    AV_WB32(data + crc_at,
            codec == AV_CODEC_ID_H264 ? crc_of_units(crc, bytes) : crc_of(crc, bytes.data(), bytes.size()));
    return {};
}

std::optional<BlockAddition> block_addition_of(const AVPacket& packet) {
    std::size_t size = 0;
    const std::uint8_t* data = av_packet_get_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, &size);
    if (!data) return std::nullopt;
    if ((size != addition_size && size != labelled_size) || AV_RB64(data) != addition_id)
        return BlockAddition{1, false};
    const std::int64_t frames = AV_RB32(data + frames_at);
    std::uint32_t crc = crc_of_addition(std::span(data, size));
    crc = crc_of(crc, packet.data, static_cast<std::size_t>(packet.size));
    BlockAddition addition{
        frames, frames > 0 && frames <= clip_tags::access_interval && AV_RB32(data + crc_at) == crc};
    if (size == labelled_size)
        addition.label = PictureLabel{static_cast<std::int64_t>(AV_RB64(data + label_at)),
                                      static_cast<std::int64_t>(AV_RB64(data + label_at + 8))};
    return addition;
}

}  // namespace touchable
