#include "engine/picture/matroska_check.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

// Element identifiers of EBML (RFC 8794) and Matroska, with their length markers.
constexpr std::uint64_t id_ebml = 0x1A45DFA3, id_segment = 0x18538067, id_cluster = 0x1F43B675,
                        id_void = 0xEC;
constexpr std::uint64_t unknown_size = ~std::uint64_t{0};
/// All of a clip but its pictures: more than the index of a day. A demuxer keeps it in memory.
constexpr std::uint64_t largest_headers = 64 << 20;

struct Element {
    std::uint64_t id = 0, size = 0;
    std::uint64_t content = 0;  ///< where it begins in the file
    std::uint64_t end() const { return content + size; }
};

/// Elements where they are said to be. Once reading fails there is nothing anywhere.
class ElementReader {
public:
    explicit ElementReader(ByteSource& bytes) : bytes_(bytes) {}
    std::uint64_t length() const { return bytes_.size(); }
    /// Why reading failed.
    const std::optional<Error>& failure() const { return failure_; }

    /// Identifier and size of the element at `position`; nothing where there is none.
    std::optional<Element> at(std::uint64_t position) {
        position_ = position;
        const auto id = number(4, true);
        const auto size = id ? number(8, false) : std::nullopt;
        if (!size) return std::nullopt;
        return Element{*id, *size, position_};
    }

    /// True unless the element begins with a CRC-32 element that the rest of it does not have.
    bool crc_holds(const Element& element) {
        std::array<std::uint8_t, 1 << 16> bytes;
        constexpr std::size_t crc_bytes = 6;  // identifier 0xBF, size 0x84, four bytes
        if (element.size < crc_bytes) return true;
        position_ = element.content;
        if (!read(bytes.data(), crc_bytes)) return false;
        if (bytes[0] != 0xBF || bytes[1] != 0x84) return true;
        const std::uint32_t stated = AV_RL32(bytes.data() + 2);
        std::uint32_t crc = ~std::uint32_t{0};
        for (std::uint64_t left = element.size - crc_bytes; left > 0;) {
            const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(left, bytes.size()));
            if (!read(bytes.data(), some)) return false;
            crc = av_crc(av_crc_get_table(AV_CRC_32_IEEE_LE), crc, bytes.data(), some);
            left -= some;
        }
        return ~crc == stated;
    }

private:
    /// A number whose first byte's leading zeros tell how many bytes follow; all ones without the marker mean
    /// an unknown size.
    std::optional<std::uint64_t> number(int longest, bool keep_marker) {
        std::uint8_t first = 0;
        if (!read(&first, 1)) return std::nullopt;
        const int following = std::countl_zero(first);
        if (following >= longest) return std::nullopt;
        const int marker = 0x80 >> following;
        auto value = static_cast<std::uint64_t>(keep_marker ? first : first & (marker - 1));
        for (int k = 0; k < following; ++k) {
            std::uint8_t next = 0;
            if (!read(&next, 1)) return std::nullopt;
            value = value << 8 | next;
        }
        const std::uint64_t all_ones = (std::uint64_t{1} << (7 * (following + 1))) - 1;
        return !keep_marker && value == all_ones ? unknown_size : value;
    }

    bool read(std::uint8_t* to, std::size_t size) {
        if (failure_ || position_ > length() || size > length() - position_) return false;
        if (auto read = bytes_.read(position_, reinterpret_cast<char*>(to), size); !read)
            failure_ = read.error();
        position_ += size;
        return !failure_;
    }

    ByteSource& bytes_;
    std::uint64_t position_ = 0;
    std::optional<Error> failure_;
};

Result<MatroskaEnd> check_segment(ElementReader& reader, const Element& segment, const std::string& file) {
    constexpr std::uint64_t longest_head = 12;  // of an element: its identifier and its size
    const bool is_stated = segment.size != unknown_size;
    const bool is_short = is_stated && segment.size > reader.length() - segment.content;
    const std::uint64_t end = is_stated && !is_short ? segment.end() : reader.length();
    std::uint64_t position = segment.content, headers = 0;
    bool has_cluster = false;
    const auto cut_here = [&](std::uint64_t at) -> Result<MatroskaEnd> {
        if (!is_stated || has_cluster) return MatroskaEnd{at, is_stated, true};
        return input_error(file + ": is truncated: it has " +
                           std::to_string(reader.length() - segment.content) + " of " +
                           std::to_string(segment.size) + " bytes, and no whole cluster of frames");
    };
    while (position < end) {
        const auto damaged = [&file, position] {
            return input_error(file + ": is damaged near byte " + std::to_string(position));
        };
        const auto element = reader.at(position);
        if (!element || element->content > end || element->size > end - element->content) {
            const bool may_be_cut = element ? element->size <= segment.size : end - position < longest_head;
            if (is_stated && !(is_short && may_be_cut)) return damaged();
            return cut_here(position);
        }
        position = element->end();
        has_cluster = has_cluster || element->id == id_cluster;
        if (element->id == id_cluster || element->id == id_void) continue;
        headers += element->size;
        if (headers > largest_headers)
            return input_error(
                file + ": its headers, tags and attachments are larger than 64 MiB together: must be less");
        if (!reader.crc_holds(*element)) return damaged();
    }
    return is_short ? cut_here(end) : MatroskaEnd{end, is_stated};
}

}  // namespace

Result<MatroskaEnd> check_matroska(ByteSource& bytes, const std::string& file) {
    ElementReader reader(bytes);
    if (reader.length() == 0) return input_error(file + ": is empty");
    const auto header = reader.at(0);
    const auto segment = header && header->id == id_ebml && header->size < reader.length()
                             ? reader.at(header->end())
                             : std::nullopt;
    if (reader.failure()) return error_at(file, *reader.failure());
    if (!header || header->id != id_ebml) return input_error(file + ": is not a Matroska file");
    if (!segment)
        return input_error(file + ": is truncated: it ends at byte " + std::to_string(reader.length()));
    if (segment->id != id_segment)
        return input_error(file + ": is damaged: its header is not followed by a segment");
    const auto end = check_segment(reader, *segment, file);
    if (reader.failure()) return error_at(file, *reader.failure());
    return end;
}

}  // namespace touchable
