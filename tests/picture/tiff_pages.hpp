#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/import/jpeg_with_xmp.hpp"

namespace touchable::test {

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
