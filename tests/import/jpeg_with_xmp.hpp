#pragma once

#include <cstdint>
#include <string>
#include <string_view>

// JPEG files as phones write them, made byte by byte.
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

}  // namespace touchable::test
