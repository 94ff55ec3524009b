#include <algorithm>
#include <cstdint>
#include <cstring>

#include "engine/video/gradient_zstd.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

std::span<const std::uint8_t> as_bytes(std::string_view bytes) {
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

/// A picture's packet is decoded to the picture, whatever was decoded before.
void require_round_trip(GradientZstdDecoder& decoder, const std::vector<std::uint16_t>& samples, int width,
                        int height) {
    GradientZstdEncoder encoder;
    const auto* const data = reinterpret_cast<const std::uint8_t*>(samples.data());
    const auto packet = encoder.encode({data, std::ptrdiff_t{2} * width, width, height, 2, 1});
    std::vector<std::uint16_t> again(samples.size());
    require(GradientZstdDecoder::promises(packet, samples.size()), "a packet does not promise its picture");
    require(decoder.decode(packet, width, height, again.data(), width), "a packet is not decoded");
    require(again == samples, "a picture comes back another");
}

/// Two bytes of size, then a packet; and the same bytes as a picture.
bool parse_gradient_zstd(std::string_view bytes) {
    Taken taken(bytes);
    const int width = static_cast<int>(taken.byte() % 64) + 1,
              height = static_cast<int>(taken.byte() % 64) + 1;
    std::vector<std::uint16_t> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const auto packet = as_bytes(taken.rest());
    GradientZstdDecoder decoder;
    const bool is_decoded = decoder.decode(packet, width, height, samples.data(), width);
    if (is_decoded) {
        require(GradientZstdDecoder::promises(packet, samples.size()),
                "a packet held what it did not promise");
    } else {
        std::memcpy(samples.data(), packet.data(), std::min(packet.size(), 2 * samples.size()));
    }
    require_round_trip(decoder, samples, width, height);
    return is_decoded;
}

const Registered gradient_zstd_target{
    {.name = "gradient_zstd", .parse = parse_gradient_zstd, .cuts_are_refused = true}};

}  // namespace
}  // namespace touchable::fuzz
