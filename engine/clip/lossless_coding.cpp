#include "engine/clip/lossless_coding.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/mpeg4/bit_stream.hpp"

namespace touchable {
namespace {

using mpeg4::BitReader;
using Parameters = std::span<const std::uint8_t>;

/// Exp-Golomb: as many bits follow as zeros came.
std::uint64_t golomb(BitReader& bits) {
    int zeros = 0;
    while (zeros < 32 && !bits.flag()) ++zeros;
    return (std::uint64_t{1} << zeros) - 1 + bits.get(zeros);
}

/// A flag of the sequence's parameters in avcC (ISO/IEC 14496-10, 7.3.2.1.1).
bool is_lossless_h264(Parameters avcc) {
    constexpr std::size_t sequence_at = 8;
    constexpr std::uint64_t high_444_predictive = 244, colours_at_full_size = 3;
    if (avcc.size() <= sequence_at) return false;
    BitReader bits(avcc.subspan(sequence_at));
    bits.get(8);
    if (bits.get(8) != high_444_predictive) return false;
    bits.get(16);
    golomb(bits);
    if (golomb(bits) == colours_at_full_size) bits.get(1);
    golomb(bits);
    golomb(bits);
    const bool leaves_out_transform = bits.flag();
    return leaves_out_transform && !bits.is_over();
}

/// The first unit of this kind in hvcC (ISO/IEC 14496-15, 8.3.3.1.2).
std::optional<Parameters> hevc_unit(Parameters hvcc, int kind) {
    std::size_t at = 22;
    const auto number = [&](std::size_t bytes) {
        std::size_t value = 0;
        for (; bytes > 0; --bytes, ++at) value = value << 8 | (at < hvcc.size() ? hvcc[at] : 0);
        return value;
    };
    for (std::size_t lists = number(1); lists > 0; --lists) {
        const bool is_wanted = static_cast<int>(number(1) & 63) == kind;
        for (std::size_t units = number(2); units > 0; --units) {
            const std::size_t length = number(2);
            if (at > hvcc.size() || length > hvcc.size() - at) return {};
            if (is_wanted) return hvcc.subspan(at, length);
            at += length;
        }
    }
    return {};
}

/// transquant_bypass_enabled_flag of the pictures' parameters (ISO/IEC 23008-2, 7.3.2.3.1). x265 sets it as
/// well where some blocks alone are lossless, and its message in the same place tells which.
bool is_lossless_hevc(Parameters hvcc) {
    constexpr int picture_parameters = 34;
    const std::string_view words(reinterpret_cast<const char*>(hvcc.data()), hvcc.size());
    if (words.find(" no-lossless") != std::string_view::npos) return false;
    const auto unit = hevc_unit(hvcc, picture_parameters);
    if (!unit) return false;
    BitReader bits(*unit);
    bits.get(16);  // what unit it is
    golomb(bits);  // its number, and the sequence's
    golomb(bits);
    bits.get(7);  // dependent slices, output flag, 3 extra bits, hidden signs, cabac_init
    for (int number = 0; number < 3; ++number) golomb(bits);  // references of two lists, quantiser
    bits.get(2);                                              // constrained intra, skipped transforms
    if (bits.flag()) golomb(bits);                            // a quantiser for each block
    golomb(bits);                                             // offsets for colour
    golomb(bits);
    bits.get(3);  // these for each slice, weights
    const bool leaves_out_transform = bits.flag();
    return leaves_out_transform && !bits.is_over();
}

}  // namespace

bool is_coded_without_loss(const AVCodecParameters& stored) {
    if (stored.extradata == nullptr || stored.extradata_size <= 0) return false;
    const Parameters parameters(stored.extradata, static_cast<std::size_t>(stored.extradata_size));
    if (stored.codec_id == AV_CODEC_ID_H264) return is_lossless_h264(parameters);
    return stored.codec_id == AV_CODEC_ID_HEVC && is_lossless_hevc(parameters);
}

}  // namespace touchable
