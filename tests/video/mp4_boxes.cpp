// SPDX-License-Identifier: Apache-2.0
#include "tests/video/mp4_boxes.hpp"

#include <gtest/gtest.h>

namespace touchable::test {

std::uint64_t number_in(const std::string& file, std::size_t at, int bytes) {
    std::uint64_t number = 0;
    for (int k = 0; k < bytes; ++k)
        number = number << 8 | static_cast<unsigned char>(file.at(at + static_cast<std::size_t>(k)));
    return number;
}

std::string bytes_in(const std::string& file, const FoundBox& box) {
    return file.substr(box.content, box.end - box.content);
}

std::string hex_digits(const std::string& bytes) {
    std::string text;
    for (const char byte : bytes)
        for (const int shift : {4, 0})
            text += "0123456789abcdef"[static_cast<unsigned char>(byte) >> shift & 15];
    return text;
}

std::vector<FoundBox> boxes_between(const std::string& file, std::size_t begin, std::size_t end) {
    std::vector<FoundBox> boxes;
    for (std::size_t at = begin; at < end;) {
        if (end - at < 8) {
            ADD_FAILURE() << end - at << " bytes are no box";
            break;
        }
        const std::uint64_t stated = number_in(file, at, 4), head = stated == 1 ? 16 : 8,
                            size = stated == 1 ? number_in(file, at + 8, 8) : stated;
        if (size < head || size > end - at) {
            ADD_FAILURE() << file.substr(at + 4, 4) << " has " << size << " of " << end - at << " bytes";
            break;
        }
        boxes.push_back({file.substr(at + 4, 4), at, at + head, at + size});
        at += size;
    }
    return boxes;
}

std::vector<FoundBox> boxes_of(const std::string& file) {
    return boxes_between(file, 0, file.size());
}

std::vector<FoundBox> boxes_named(const std::string& file, const FoundBox& in, std::string_view type) {
    std::vector<FoundBox> found = boxes_between(file, in.content, in.end);
    std::erase_if(found, [type](const FoundBox& box) { return box.type != type; });
    return found;
}

FoundBox box_at(const std::string& file, const FoundBox& in, const std::vector<std::string>& path) {
    FoundBox box = in;
    for (const std::string& type : path) {
        const auto found = boxes_named(file, box, type);
        if (found.empty()) {
            ADD_FAILURE() << box.type << " has no " << type;
            return {};
        }
        box = found.front();
    }
    return box;
}

std::vector<FoundBox> tracks_in(const std::string& file) {
    return boxes_named(file, boxes_of(file).back(), "trak");
}

std::string handler_of(const std::string& file, const FoundBox& track) {
    return file.substr(box_at(file, track, {"mdia", "hdlr"}).content + 8, 4);
}

std::uint64_t id_of(const std::string& file, const FoundBox& track) {
    const FoundBox head = box_at(file, track, {"tkhd"});
    return number_in(file, head.content + (file.at(head.content) == 1 ? 20 : 12), 4);
}

std::string sample_of(const std::string& file, const FoundBox& track) {
    const FoundBox tables = box_at(file, track, {"mdia", "minf", "stbl"}),
                   sizes = box_at(file, tables, {"stsz"}), places = box_at(file, tables, {"co64"});
    EXPECT_EQ(number_in(file, sizes.content + 4, 4), 0U);
    EXPECT_EQ(number_in(file, sizes.content + 8, 4), 1U) << "samples";
    EXPECT_EQ(number_in(file, places.content + 4, 4), 1U) << "chunks";
    return file.substr(number_in(file, places.content + 8, 8), number_in(file, sizes.content + 12, 4));
}

std::string without_in_movie(const std::string& file, const std::vector<std::string>& types) {
    const FoundBox movie = boxes_of(file).back();
    EXPECT_EQ(movie.type, "moov");
    std::string content;
    std::size_t left_out = 0;
    for (const FoundBox& box : boxes_between(file, movie.content, movie.end)) {
        const bool stays = std::find(types.begin(), types.end(), box.type) == types.end();
        if (stays) content += file.substr(box.at, box.end - box.at);
        left_out += stays ? 0 : 1;
    }
    EXPECT_GT(left_out, 0U);
    return file.substr(0, movie.at) + word(content.size() + 8) + "moov" + content;
}

std::string word(std::size_t value) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift);
    return bytes;
}

}  // namespace touchable::test
