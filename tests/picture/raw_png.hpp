#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "engine/picture/ffmpeg.hpp"
#include "tests/import/jpeg_with_xmp.hpp"

extern "C" {
#include <libavutil/adler32.h>
#include <libavutil/crc.h>
}

namespace touchable::test {

/// The header's fields: bits of a sample, kind (0 grey, 2 RGB, 3 palette), interlacing.
struct PngKind {
    int width, height, bits = 8, colour = 0, interlaced = 0;
};

inline std::string png_chunk(const std::string& name, const std::string& content) {
    const std::string body = name + content;
    const std::uint32_t crc = ~av_crc(av_crc_get_table(AV_CRC_32_IEEE_LE), ~std::uint32_t{0},
                                      reinterpret_cast<const std::uint8_t*>(body.data()), body.size());
    return big_endian(content.size(), 4) + body + big_endian(crc, 4);
}

/// A zlib stream that holds `bytes` as they are, in blocks of up to 65535; with an end, or cut before it.
inline std::string stored_zlib(const std::string& bytes, bool ended) {
    std::string stream("\x78\x01", 2);
    constexpr std::size_t largest_block = 65535;
    for (std::size_t at = 0; at == 0 || at < bytes.size(); at += largest_block) {
        const auto size = static_cast<std::uint16_t>(std::min(largest_block, bytes.size() - at)),
                   other = static_cast<std::uint16_t>(~size);
        stream += ended && at + size == bytes.size() ? '\1' : '\0';
        for (const std::uint16_t word : {size, other}) {
            stream += static_cast<char>(word & 255);
            stream += static_cast<char>(word >> 8);
        }
        stream.append(bytes, at, size);
    }
    if (!ended) return stream;
    const auto sum = av_adler32_update(1, reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                       static_cast<std::uint32_t>(bytes.size()));
    return stream + big_endian(sum, 4);
}

/// A PNG of these rows, each with its filter's number before it; `others` are chunks before the picture's.
inline std::string raw_png(const PngKind& kind, const std::string& rows, bool ended = true,
                           const std::string& others = "") {
    const std::string header = big_endian(static_cast<std::uint64_t>(kind.width), 4) +
                               big_endian(static_cast<std::uint64_t>(kind.height), 4) +
                               static_cast<char>(kind.bits) + static_cast<char>(kind.colour) +
                               std::string(2, '\0') + static_cast<char>(kind.interlaced);
    return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + others +
           png_chunk("IDAT", stored_zlib(rows, ended)) + png_chunk("IEND", "");
}

}  // namespace touchable::test
