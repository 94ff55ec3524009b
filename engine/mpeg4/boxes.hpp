#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.hpp"

namespace touchable::mpeg4 {

using Bytes = std::vector<std::uint8_t>;
using BytesView = std::span<const std::uint8_t>;

/// A box of an MP4 file (ISO/IEC 14496-12): a length, four letters, and what is in it.
struct Box {
    std::string type;
    BytesView content;  ///< of the bytes that were parsed
};

/// The boxes that these bytes are, one after the other. An error where one is longer than what is left.
Result<std::vector<Box>> boxes_in(BytesView bytes);
/// The first of a type; null where there is none.
const Box* box_named(std::span<const Box> boxes, std::string_view type);
/// The box in a box in these bytes, by types from the outermost to itself; empty where there is none.
BytesView content_at(BytesView bytes, std::initializer_list<std::string_view> path);

/// A whole number of so many bytes, the highest first.
std::uint64_t number_at(BytesView bytes, std::size_t at, int count);
void put_number(Bytes& to, std::uint64_t value, int count);
void put_bytes(Bytes& to, BytesView bytes);
/// A whole box, at the end.
void put_box(Bytes& to, std::string_view type, BytesView content);
Bytes box_of(std::string_view type, BytesView content);

}  // namespace touchable::mpeg4
