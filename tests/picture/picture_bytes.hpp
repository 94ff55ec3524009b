// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files of pictures, made byte by byte: JPEG as phones write it, PNG and TIFF of all kinds.

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/picture/ffmpeg.hpp"

extern "C" {
#include <libavutil/adler32.h>
#include <libavutil/crc.h>
}

namespace touchable::test {

inline std::string big_endian(std::uint64_t number, int bytes) {
    std::string text;
    for (int k = bytes - 1; k >= 0; --k) text += static_cast<char>(number >> (8 * k) & 255);
    return text;
}

inline std::string segment(char marker, const std::string& content) {
    return std::string("\xff") + marker + big_endian(content.size() + 2, 2) + content;
}

inline std::string xmp_segment(const std::string& packet) {
    return segment('\xe1', std::string("http://ns.adobe.com/xap/1.0/") + '\0' + packet);
}

inline std::string extension_header() {
    return std::string("http://ns.adobe.com/xmp/extension/") + '\0';
}

/// The name of an extended packet: 32 digits, an MD5 sum if a camera wrote it.
inline constexpr const char* guid = "0123456789ABCDEF0123456789ABCDEF";

/// Bytes `from` to `to` of an extended packet, said to be of its length or of another.
inline std::string extension_segment(const std::string& its_guid, const std::string& packet, std::size_t from,
                                     std::size_t to, std::uint64_t length = 0) {
    return segment('\xe1', extension_header() + its_guid +
                               big_endian(length == 0 ? packet.size() : length, 4) + big_endian(from, 4) +
                               packet.substr(from, to - from));
}

/// The segments between a JPEG's first bytes and its picture.
inline std::string jpeg_around(const std::string& segments, const std::string& picture = "picture\xff\xd9") {
    return "\xff\xd8" + segments + std::string("\xff\xda\0\x08", 4) + picture;
}

inline std::string encode_base64(std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t k = 0; k < bytes.size(); k += 3) {
        std::uint32_t bits = 0;
        for (std::size_t n = 0; n < 3; ++n)
            bits = bits << 8 | (k + n < bytes.size() ? static_cast<unsigned char>(bytes[k + n]) : 0U);
        for (std::size_t n = 0; n < 4; ++n)
            text += k + n <= bytes.size() ? digits[bits >> (18 - 6 * n) & 63] : '=';
    }
    return text;
}

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

/// A number of so many bytes.
inline std::string tiff_number(std::uint64_t value, int bytes, bool big) {
    std::string text = big_endian(value, bytes);
    if (!big) std::reverse(text.begin(), text.end());
    return text;
}

/// A page of a TIFF: grey integers in one strip, not packed.
struct TiffPageOf {
    int width = 0, height = 0;
    std::vector<std::uint32_t> codes{};
    int bits = 16;
    int subfile = 0;  ///< NewSubfileType: 1 a smaller copy, 4 a mask
    int photometric = 1;
};

/// A page whose every pixel is `code`.
inline TiffPageOf even_page(std::uint32_t code, int width = 7, int height = 5, int bits = 16) {
    return {
        width, height,
        std::vector<std::uint32_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), code),
        bits};
}

/// The whole file; `behind_last` is where the last directory says that another one is.
inline std::string tiff_pages(const std::vector<TiffPageOf>& pages, bool big = false,
                              std::uint32_t behind_last = 0) {
    const auto number = [big](std::uint64_t value, int bytes) { return tiff_number(value, bytes, big); };
    std::string file = (big ? std::string("MM\0*", 4) : std::string("II*\0", 4)) + number(8, 4);
    for (std::size_t k = 0; k < pages.size(); ++k) {
        const TiffPageOf& page = pages[k];
        std::string data;
        for (const std::uint32_t code : page.codes) data += number(code, page.bits / 8);
        const auto width = static_cast<std::uint64_t>(page.width),
                   height = static_cast<std::uint64_t>(page.height);
        const std::vector<std::pair<int, std::uint64_t>> tags = {
            {254, static_cast<std::uint64_t>(page.subfile)},
            {256, width},
            {257, height},
            {258, static_cast<std::uint64_t>(page.bits)},
            {259, 1},
            {262, static_cast<std::uint64_t>(page.photometric)},
            {273, file.size() + 2 + 12 * 11 + 4},
            {277, 1},
            {278, height},
            {279, data.size()},
            {339, 1}};
        file += number(tags.size(), 2);
        for (const auto& [tag, value] : tags)
            file +=
                number(static_cast<std::uint64_t>(tag), 2) + number(4, 2) + number(1, 4) + number(value, 4);
        const std::size_t next = file.size() + 4 + data.size();
        file += number(k + 1 < pages.size() ? next : behind_last, 4) + data;
    }
    return file;
}

}  // namespace touchable::test
