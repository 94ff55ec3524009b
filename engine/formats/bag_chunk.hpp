#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Unpacks `packed` bytes of a file from `at` on, which `compression` ("bz2", "lz4", "zstd", or
/// empty: none) made of `size` bytes.
/// Refused where they are not exactly so many. An error says what is wrong, but not in which file.
Result<std::string> unpack_bag_chunk(std::string_view compression, ByteSource& file, std::uint64_t at,
                                     std::uint32_t packed, std::uint32_t size);

}  // namespace touchable
