#pragma once

#include <cstdint>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Of QuickTime and MP4, up to `end`: whether the tables of samples hold what they claim. FFmpeg takes memory
/// for all that a table claims before it reads any of it. Refused (ErrorKind::input) are one that claims more
/// than it holds, and samples without a table of their own, or played again and again, of which there are
/// more than the file has bytes for.
Result<void> check_box_tables(ByteSource& bytes, std::uint64_t end);

}  // namespace touchable
