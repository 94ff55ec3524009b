#include "engine/picture/container_end.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "engine/base/try.hpp"
#include "engine/picture/matroska_check.hpp"

extern "C" {
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

/// As many as there are; the rest is zero.
template <std::size_t count>
Result<std::array<std::uint8_t, count>> head_at(ByteSource& bytes, std::uint64_t position) {
    std::array<std::uint8_t, count> head{};
    const auto some = std::min<std::uint64_t>(count, bytes.size() - position);
    if (auto read =
            bytes.read(position, reinterpret_cast<char*>(head.data()), static_cast<std::size_t>(some));
        !read)
        return read.error();
    return head;
}

}  // namespace

Result<std::optional<std::uint64_t>> end_of_boxes(ByteSource& bytes) {
    const std::uint64_t length = bytes.size();
    std::uint64_t position = 0;
    while (position < length) {
        TRY_ASSIGN(const auto head, head_at<16>(bytes, position));
        const bool is_json = head[0] == '{' && head[1] == '"';
        const bool is_nothing =
            std::all_of(head.begin(), head.begin() + 8, [](auto byte) { return byte == 0; });
        if (position > 0 && (is_json || is_nothing)) return std::optional(position);
        const std::uint64_t stated = AV_RB32(head.data());
        const std::uint64_t size = stated == 0   ? length - position  // to the end of the file
                                   : stated == 1 ? AV_RB64(head.data() + 8)
                                                 : stated;
        if (size < 8 || size > length - position) return std::optional<std::uint64_t>();
        position += size;
    }
    return length > 0 ? std::optional(length) : std::nullopt;
}

Result<std::optional<std::uint64_t>> end_of_riff(ByteSource& bytes) {
    const std::uint64_t length = bytes.size();
    std::uint64_t position = 0;
    while (position + 8 < length) {
        TRY_ASSIGN(const auto head, head_at<8>(bytes, position));
        const bool is_chunk = AV_RB32(head.data()) == AV_RB32("RIFF");
        if (!is_chunk && position > 0) break;
        const std::uint64_t end = position + 8 + AV_RL32(head.data() + 4);
        if (!is_chunk || end == position + 8 || end > length) return std::optional<std::uint64_t>();
        position = end;
    }
    return position > 0 ? std::optional(position) : std::nullopt;
}

Result<std::uint64_t> end_of_container(ByteSource& bytes, const std::string& file) {
    const std::string begin = first_bytes(bytes, 4);
    if (begin == "\x1a\x45\xdf\xa3") {
        const auto end = check_matroska(bytes, file);
        if (!end && end.error().kind == ErrorKind::interrupted) return end.error();
        return end ? end->at : bytes.size();
    }
    TRY_ASSIGN(const auto end, begin == "RIFF" ? end_of_riff(bytes) : end_of_boxes(bytes));
    return end.value_or(bytes.size());
}

}  // namespace touchable
