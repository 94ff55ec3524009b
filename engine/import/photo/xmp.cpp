#include "engine/import/photo/xmp.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "engine/import/photo/jpeg_segments.hpp"

namespace touchable {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view packet_header = "http://ns.adobe.com/xap/1.0/\0"sv;
constexpr std::string_view extension_header = "http://ns.adobe.com/xmp/extension/\0"sv;
constexpr std::size_t guid_length = 32;

std::size_t big_endian(std::string_view bytes) {
    std::size_t number = 0;
    for (const char byte : bytes) number = number << 8 | static_cast<unsigned char>(byte);
    return number;
}

struct Piece {
    std::size_t whole = 0, offset = 0;
    std::string_view bytes;
};

/// Pieces of the extended packet named `guid`, by offset.
std::vector<Piece> pieces_of(const std::vector<std::string_view>& segments, std::string_view guid) {
    std::vector<Piece> pieces;
    for (std::string_view segment : segments) {
        if (!segment.starts_with(extension_header)) continue;
        segment.remove_prefix(extension_header.size());
        if (segment.size() < guid_length + 8 || segment.substr(0, guid_length) != guid) continue;
        pieces.push_back({big_endian(segment.substr(guid_length, 4)),
                          big_endian(segment.substr(guid_length + 4, 4)), segment.substr(guid_length + 8)});
    }
    std::sort(pieces.begin(), pieces.end(),
              [](const Piece& a, const Piece& b) { return a.offset < b.offset; });
    return pieces;
}

/// Every byte of the packet once, or an error.
Result<std::string> joined(const std::vector<Piece>& pieces, const std::string& where) {
    if (pieces.empty())
        return input_error(where + ": its XMP names an extended packet that is not in the file");
    std::string packet;
    for (const Piece& piece : pieces) {
        if (piece.whole != pieces.front().whole)
            return input_error(where + ": pieces of its extended XMP disagree on its length");
        if (piece.offset != packet.size())
            return input_error(where + ": its extended XMP has " +
                               (piece.offset > packet.size() ? "a gap" : "pieces that overlap") +
                               " at byte " + std::to_string(std::min(piece.offset, packet.size())));
        packet += piece.bytes;
    }
    if (packet.size() == pieces.front().whole) return packet;
    return input_error(where + ": its extended XMP is " + std::to_string(packet.size()) + " bytes, not " +
                       std::to_string(pieces.front().whole) + " as it says");
}

/// Walks over the tags of an XML text.
class TagReader {
public:
    explicit TagReader(std::string_view text) : rest_(text) {}

    /// False where the text is not well-formed.
    bool read(XmpEntries& entries) {
        while (skip_past("<")) {
            const bool declares = rest_.starts_with("!") || rest_.starts_with("?") || rest_.starts_with("/");
            const bool whole = rest_.starts_with("!--") ? skip_past("-->")
                               : declares               ? skip_past(">")
                                                        : read_tag(entries);
            if (!whole) return false;
        }
        return true;
    }

private:
    static constexpr std::string_view space = " \t\r\n";

    bool skip_past(std::string_view mark) {
        const auto at = rest_.find(mark);
        if (at == std::string_view::npos) return false;
        rest_.remove_prefix(at + mark.size());
        return true;
    }
    void skip_space() { rest_.remove_prefix(std::min(rest_.find_first_not_of(space), rest_.size())); }
    std::string_view take_until(std::string_view marks) {
        const auto end = std::min(rest_.find_first_of(marks), rest_.size());
        const auto taken = rest_.substr(0, end);
        rest_.remove_prefix(end);
        return taken;
    }
    bool read_tag(XmpEntries& entries);
    bool read_attribute(XmpEntries& entries);

    std::string_view rest_;
};

bool TagReader::read_tag(XmpEntries& entries) {
    const std::string_view name = take_until(" \t\r\n/>");
    if (name.empty()) return false;
    entries.push_back({std::string(name), std::nullopt});
    while (true) {
        skip_space();
        if (rest_.starts_with("/>")) return true;
        if (rest_.starts_with(">")) break;
        if (!read_attribute(entries)) return false;
    }
    rest_.remove_prefix(1);
    const auto end = std::min(rest_.find('<'), rest_.size());
    const std::string closing = "</" + std::string(name) + ">";
    if (rest_.substr(end).starts_with(closing))
        entries.push_back({std::string(name), std::string(rest_.substr(0, end))});
    return true;
}

bool TagReader::read_attribute(XmpEntries& entries) {
    const std::string_view name = take_until(" \t\r\n=/><\"'");
    skip_space();
    if (name.empty() || !rest_.starts_with("=")) return false;
    rest_.remove_prefix(1);
    skip_space();
    if (!rest_.starts_with("\"") && !rest_.starts_with("'")) return false;
    const std::string_view quote = rest_.substr(0, 1);
    rest_.remove_prefix(1);
    const std::string_view value = take_until(quote);
    if (rest_.empty()) return false;
    rest_.remove_prefix(1);
    entries.push_back({std::string(name), std::string(value)});
    return true;
}

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

std::optional<XmpEntries> parse_xmp_entries(std::string_view packet) {
    XmpEntries entries;
    if (!TagReader(packet).read(entries)) return std::nullopt;
    return entries;
}

XmpProperties properties_of(const XmpEntries& entries) {
    XmpProperties properties;
    for (const XmpEntry& entry : entries)
        if (entry.value) properties.insert_or_assign(entry.name, *entry.value);
    return properties;
}

std::optional<XmpProperties> parse_xmp(std::string_view packet) {
    const auto entries = parse_xmp_entries(packet);
    if (!entries) return std::nullopt;
    return properties_of(*entries);
}

Result<XmpEntries> read_jpeg_xmp_entries(std::string_view jpeg, const std::string& where) {
    const auto segments = app1_segments(jpeg);
    if (!segments) return input_error(where + ": is not a whole JPEG: a segment before its picture is cut");
    const auto packet = std::find_if(segments->begin(), segments->end(), [](std::string_view segment) {
        return segment.starts_with(packet_header);
    });
    if (packet == segments->end()) return XmpEntries{};
    auto entries = parse_xmp_entries(packet->substr(packet_header.size()));
    if (!entries) return input_error(where + ": its XMP is not well-formed");
    const XmpProperties properties = properties_of(*entries);
    const auto guid = properties.find("xmpNote:HasExtendedXMP");
    if (guid == properties.end()) return std::move(*entries);
    auto text = joined(pieces_of(*segments, guid->second), where);
    if (!text) return text.error();
    auto extended = parse_xmp_entries(*text);
    if (!extended) return input_error(where + ": its extended XMP is not well-formed");
    std::move(entries->begin(), entries->end(), std::back_inserter(*extended));
    return std::move(*extended);
}

Result<XmpProperties> read_jpeg_xmp(std::string_view jpeg, const std::string& where) {
    const auto entries = read_jpeg_xmp_entries(jpeg, where);
    if (!entries) return entries.error();
    return properties_of(*entries);
}

std::optional<std::string> decode_base64(std::string_view text) {
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3);
    std::uint32_t bits = 0;
    int digits = 0, padding = 0;
    for (const char c : text) {
        if (c == ' ' || c == '\t' || c == '\r' || c == '\n') continue;
        const int digit = c == '=' ? 0 : base64_digit(c);
        if (c == '=') ++padding;
        if (digit < 0 || (padding > 0 && c != '=')) return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(digit);
        if (++digits % 4 != 0) continue;
        for (int shift = 16; shift >= 0; shift -= 8) bytes += static_cast<char>(bits >> shift & 255);
    }
    if (digits % 4 != 0 || padding > 2) return std::nullopt;
    bytes.resize(bytes.size() - static_cast<std::size_t>(padding));
    return bytes;
}

}  // namespace touchable
