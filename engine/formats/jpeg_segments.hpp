#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace touchable {

/// The contents of a JPEG's segments APP1, up to its picture. Nothing where a segment is cut.
std::optional<std::vector<std::string_view>> app1_segments(std::string_view jpeg);

/// Bytes of the first picture in a file, which others may follow. Nothing where its end is missing.
std::optional<std::size_t> jpeg_length(std::string_view file);

}  // namespace touchable
