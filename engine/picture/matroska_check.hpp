#pragma once

#include <cstdint>
#include <string>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Where a segment ends: what the file has behind it is not of it.
struct MatroskaEnd {
    std::uint64_t at = 0;
    /// Otherwise it does not say how long it is, as of a stream or of a file that was never completed, and it
    /// ends with its last whole element.
    bool is_stated = true;
    /// There is a part of one more element, or the file is shorter than its segment says: it ends with its
    /// last whole element too.
    bool is_cut = false;
};

/// What FFmpeg's demuxer does not tell: whether a Matroska file is whole (its segment is as long as it says),
/// or cut behind a whole cluster (before one it is refused), and whether its headers, tags and attachments
/// are as they were written (their CRC-32, where they carry one). Clusters are skipped: decoding finds what
/// is wrong with them. Says "file: what is wrong".
Result<MatroskaEnd> check_matroska(ByteSource& bytes, const std::string& file);

}  // namespace touchable
