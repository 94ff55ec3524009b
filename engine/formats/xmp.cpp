#include "engine/formats/xmp.hpp"

#include <algorithm>
#include <iterator>
#include <pugixml.hpp>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/formats/jpeg_segments.hpp"

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

/// Lists each element with its attributes, and its text where it holds nothing else.
struct EntryLister : pugi::xml_tree_walker {
    XmpEntries entries;
    bool for_each(pugi::xml_node& node) override {
        if (node.type() != pugi::node_element) return true;
        entries.push_back({node.name(), std::nullopt});
        for (const pugi::xml_attribute& attribute : node.attributes())
            entries.push_back({attribute.name(), attribute.value()});
        const pugi::xml_node text = node.first_child();
        if (text.type() == pugi::node_pcdata && !text.next_sibling())
            entries.push_back({node.name(), text.value()});
        return true;
    }
};

}  // namespace

std::optional<XmpEntries> parse_xmp_entries(std::string_view packet) {
    // Minimal: values are kept as written. A fragment: a packet may be empty.
    pugi::xml_document document;
    constexpr unsigned as_written = pugi::parse_minimal | pugi::parse_fragment;
    if (!document.load_buffer(packet.data(), packet.size(), as_written, pugi::encoding_utf8))
        return std::nullopt;
    EntryLister lister;
    document.traverse(lister);
    return std::move(lister.entries);
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
    TRY_ASSIGN(auto text, joined(pieces_of(*segments, guid->second), where));
    auto extended = parse_xmp_entries(text);
    if (!extended) return input_error(where + ": its extended XMP is not well-formed");
    std::move(entries->begin(), entries->end(), std::back_inserter(*extended));
    return std::move(*extended);
}

Result<XmpProperties> read_jpeg_xmp(std::string_view jpeg, const std::string& where) {
    TRY_ASSIGN(const auto entries, read_jpeg_xmp_entries(jpeg, where));
    return properties_of(entries);
}

}  // namespace touchable
