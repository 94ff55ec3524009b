#include "engine/media/matroska_check.hpp"

#include <bit>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

// Element identifiers of EBML (RFC 8794) and Matroska, with their length markers.
constexpr std::uint64_t id_ebml = 0x1A45DFA3, id_segment = 0x18538067, id_cluster = 0x1F43B675;
constexpr std::uint64_t unknown_size = ~std::uint64_t{0};

struct Element {
    std::uint64_t id = 0, size = 0;
    std::uint64_t content = 0;  ///< where it begins in the file
    std::uint64_t end() const { return content + size; }
};

class ElementReader {
public:
    explicit ElementReader(const std::filesystem::path& file) : in_(file, std::ios::binary) {
        in_.seekg(0, std::ios::end);
        if (in_) length_ = static_cast<std::uint64_t>(in_.tellg());
    }
    bool opened() const { return in_.is_open(); }
    std::uint64_t length() const { return length_; }

    /// Identifier and size of the element at `position`; nothing where there is none.
    std::optional<Element> at(std::uint64_t position) {
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(position));
        const auto id = number(4, true);
        const auto size = id ? number(8, false) : std::nullopt;
        if (!size) return std::nullopt;
        return Element{*id, *size, static_cast<std::uint64_t>(in_.tellg())};
    }

    /// True unless the element begins with a CRC-32 element that the rest of it does not have.
    bool crc_holds(const Element& element) {
        constexpr std::size_t crc_bytes = 6;  // identifier 0xBF, size 0x84, four bytes
        if (element.size < crc_bytes) return true;
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(element.content));
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(element.size));
        if (!in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
            return false;
        if (bytes[0] != 0xBF || bytes[1] != 0x84) return true;
        const std::uint32_t crc = ~av_crc(av_crc_get_table(AV_CRC_32_IEEE_LE), ~std::uint32_t{0},
                                          bytes.data() + crc_bytes, bytes.size() - crc_bytes);
        return crc == AV_RL32(bytes.data() + 2);
    }

private:
    /// A number whose first byte's leading zeros tell how many bytes follow; all ones without the marker mean
    /// an unknown size.
    std::optional<std::uint64_t> number(int longest, bool keep_marker) {
        const int first = in_.get();
        if (first == std::char_traits<char>::eof()) return std::nullopt;
        const int following = std::countl_zero(static_cast<std::uint8_t>(first));
        if (following >= longest) return std::nullopt;
        const int marker = 0x80 >> following;
        std::uint64_t value = static_cast<std::uint64_t>(keep_marker ? first : first & (marker - 1));
        for (int k = 0; k < following; ++k) {
            const int next = in_.get();
            if (next == std::char_traits<char>::eof()) return std::nullopt;
            value = value << 8 | static_cast<std::uint64_t>(next);
        }
        const std::uint64_t all_ones = (std::uint64_t{1} << (7 * (following + 1))) - 1;
        return !keep_marker && value == all_ones ? unknown_size : value;
    }

    std::ifstream in_;
    std::uint64_t length_ = 0;
};

Result<void> check_segment(ElementReader& reader, const Element& segment, const std::string& file) {
    std::uint64_t position = segment.content;
    while (position < segment.end()) {
        const auto damaged = [&] {
            return input_error(file + ": is damaged near byte " + std::to_string(position));
        };
        const auto element = reader.at(position);
        if (!element || element->size > segment.end() - element->content) return damaged();
        if (element->id != id_cluster && !reader.crc_holds(*element)) return damaged();
        position = element->end();
    }
    return {};
}

}  // namespace

Result<void> check_matroska(const std::filesystem::path& path) {
    const std::string file = path.string();
    ElementReader reader(path);
    if (!reader.opened()) return input_error(file + ": cannot be read");
    if (reader.length() == 0) return input_error(file + ": is empty");
    const auto header = reader.at(0);
    if (!header || header->id != id_ebml) return input_error(file + ": is not a Matroska file");
    const auto truncated = [&] {
        return input_error(file + ": is truncated: it ends at byte " + std::to_string(reader.length()));
    };
    if (header->size >= reader.length()) return truncated();
    const auto segment = reader.at(header->end());
    if (!segment) return truncated();
    if (segment->id != id_segment)
        return input_error(file + ": is damaged: its header is not followed by a segment");
    if (segment->size == unknown_size)
        return input_error(file + ": was never completed: whoever wrote it stopped before the end");
    if (segment->size > reader.length() - segment->content)
        return input_error(file + ": is truncated: it has " +
                           std::to_string(reader.length() - segment->content) + " of " +
                           std::to_string(segment->size) + " bytes");
    return check_segment(reader, *segment, file);
}

}  // namespace touchable
