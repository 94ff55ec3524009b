#pragma once

#include <cstdint>
#include <string>

#include "engine/byte_source.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Where a segment ends: what the file has behind it is not of it.
struct MatroskaEnd {
    std::uint64_t at = 0;
    /// Otherwise it does not say how long it is, as of a stream or of a file that was never completed, and it
    /// ends with its last whole element.
    bool is_stated = true;
    bool is_cut = false;  ///< of such a one: there is a part of one more
};

/// What FFmpeg's demuxer does not tell: whether a Matroska file is whole (its segment is as long as it says),
/// and whether its headers, tags and attachments are as they were written (their CRC-32, where they carry
/// one). Clusters are skipped: decoding finds what is wrong with them. Says "file: what is wrong".
Result<MatroskaEnd> check_matroska(ByteSource& bytes, const std::string& file);

}  // namespace touchable
