#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// Properties by qualified name, "GDepth:Near"; values as written.
using XmpProperties = std::map<std::string, std::string, std::less<>>;

/// A property, or the beginning of an element, which has no value.
struct XmpEntry {
    std::string name;
    std::optional<std::string> value;
};
/// In the order in which they stand: for lists, whose items have properties of the same names.
using XmpEntries = std::vector<XmpEntry>;

/// The last of each name.
XmpProperties properties_of(const XmpEntries& entries);

/// The XMP of a JPEG file: its packet, and the extended packet that it names, put together from its pieces.
/// Empty where the file has none. Prefixes are taken as they stand, without their namespaces. Messages begin
/// with `where`.
Result<XmpProperties> read_jpeg_xmp(std::string_view jpeg, const std::string& where);
/// The same in order, the extended packet first.
Result<XmpEntries> read_jpeg_xmp_entries(std::string_view jpeg, const std::string& where);

/// Properties of one packet: attributes, and elements that hold nothing but text (an empty one has no
/// value). Nothing where it is not well-formed.
std::optional<XmpProperties> parse_xmp(std::string_view packet);
std::optional<XmpEntries> parse_xmp_entries(std::string_view packet);

}  // namespace touchable
