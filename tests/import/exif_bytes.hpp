#pragma once

#include <algorithm>
#include <string>

#include "tests/import/jpeg_with_xmp.hpp"

namespace touchable::test {

/// EXIF's TIFF structure, of an orientation and a focal length in terms of 35 mm film.
inline std::string exif_bytes(int orientation, int film_focal_length, bool is_big_endian = true) {
    const auto number = [&](std::uint64_t value, int bytes) {
        std::string text = big_endian(value, bytes);
        if (!is_big_endian) std::reverse(text.begin(), text.end());
        return text;
    };
    const auto entry = [&](int tag, int type, std::string value) {
        value.resize(4, '\0');
        return number(static_cast<std::uint64_t>(tag), 2) + number(static_cast<std::uint64_t>(type), 2) +
               number(1, 4) + value;
    };
    const auto directory = [&](const std::string& entries) {
        return number(entries.size() / 12, 2) + entries + number(0, 4);
    };
    const std::string first = entry(0x0112, 3, number(static_cast<std::uint64_t>(orientation), 2)) +
                              entry(0x8769, 4, number(8 + 6 + 24, 4));
    return (is_big_endian ? std::string("MM\0*", 4) : std::string("II*\0", 4)) + number(8, 4) +
           directory(first) +
           directory(entry(0x9000, 7, "0232") +
                     entry(0xa405, 3, number(static_cast<std::uint64_t>(film_focal_length), 2)));
}

inline std::string exif_segment(const std::string& tiff) {
    return segment('\xe1', std::string("Exif\0\0", 6) + tiff);
}

}  // namespace touchable::test
