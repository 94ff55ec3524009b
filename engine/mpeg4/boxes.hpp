#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable::mpeg4 {

using Bytes = std::vector<std::uint8_t>;
using BytesView = std::span<const std::uint8_t>;

/// A box of an MP4 file (ISO/IEC 14496-12): a length, four letters, and what is in it.
struct Box {
    std::string type;
    BytesView content;  ///< of the bytes that were parsed
};

/// The boxes that these bytes are, one after the other. An error where one is longer than what is left, or
/// there are more than 65536.
Result<std::vector<Box>> boxes_in(BytesView bytes);
/// The first of a type; null where there is none.
const Box* box_named(std::span<const Box> boxes, std::string_view type);
/// The box in a box in these bytes, by types from the outermost to itself; empty where there is none.
BytesView content_at(BytesView bytes, std::initializer_list<std::string_view> path);

/// The same boxes, but that the one at this path has another content.
Bytes with_content(BytesView boxes, std::span<const std::string_view> path, BytesView content);

/// Where a box of a file is: from its head, by what is in it, to the next one.
struct BoxPlace {
    std::string type;
    std::uint64_t at = 0, content = 0, end = 0;
};
/// The box that begins there, of a file or of a box that ends at `end`; nothing where it would end later.
Result<std::optional<BoxPlace>> box_at(ByteSource& file, std::uint64_t at, std::uint64_t end);
/// The first of a type between two places; nothing where there is none before one that is cut.
Result<std::optional<BoxPlace>> first_box(ByteSource& file, std::string_view type, std::uint64_t at,
                                          std::uint64_t end);
/// Bytes of a file. An error where they are not all there.
Result<Bytes> bytes_at(ByteSource& file, std::uint64_t at, std::uint64_t count);
/// The content of the file's movie box, without what is long and says nothing but where samples are; empty
/// where there is no such box. An error where 16 MiB would be left.
Result<Bytes> movie_head_of(ByteSource& file);

/// A whole number of so many bytes, the highest first.
std::uint64_t number_at(BytesView bytes, std::size_t at, int count);
void put_number(Bytes& to, std::uint64_t value, int count);
void put_bytes(Bytes& to, BytesView bytes);
/// A whole box, at the end.
void put_box(Bytes& to, std::string_view type, BytesView content);
Bytes box_of(std::string_view type, BytesView content);

}  // namespace touchable::mpeg4
