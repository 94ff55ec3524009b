// Packets of our own codec, of both versions: two bytes of size, then the packet; and the same bytes as a
// picture.
#include <algorithm>
#include <cstdint>
#include <cstring>

#include "engine/clip/track_codecs.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

using Version = RankZstdDecoder::Version;

struct CodedPicture {
    int width, height;
    std::vector<std::uint16_t> samples;

    bool is_decoded(RankZstdDecoder& decoder, std::span<const std::uint8_t> packet) {
        return decoder.decode(packet, width, height, samples.data(), width);
    }
};

/// A picture's packet is decoded to the picture, whatever was encoded and decoded before.
void require_round_trip(RankZstdEncoder& encoder, RankZstdDecoder& decoder, const CodedPicture& picture,
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
    RankZstdEncoder encoder;
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
