#pragma once

#include <cstdint>
#include <string>

#include "engine/byte_source.hpp"
#include "engine/result.hpp"

namespace touchable {

/// What FFmpeg's demuxer does not tell: whether a Matroska file is whole (its segment is as long as it says),
/// and whether its headers, tags and attachments are as they were written (their CRC-32, where they carry
/// one). Clusters are skipped: decoding finds what is wrong with them. Gives where the segment ends: what the
/// file has behind it is not of it. Says "file: what is wrong".
Result<std::uint64_t> check_matroska(ByteSource& bytes, const std::string& file);

}  // namespace touchable
