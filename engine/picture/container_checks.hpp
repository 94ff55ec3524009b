#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace touchable {

// Where a container ends by its own account, which need not be where its file does: a recorder that crashed
// leaves the room that it had asked for, gigabytes of zeros, and one that is at work goes on writing.

/// Of QuickTime and MP4, behind its outermost boxes, each a length, a type and a content; nothing where one
/// is cut, with which FFmpeg is content. Record3D puts JSON behind the last box.
Result<std::optional<std::uint64_t>> end_of_boxes(ByteSource& bytes);

/// Of AVI and WAV, behind its first chunk and further ones of a large file; nothing where one is cut.
Result<std::optional<std::uint64_t>> end_of_riff(ByteSource& bytes);

/// Of any container that has sound (Matroska, QuickTime, WAV, AVI), or all of the bytes where it does not
/// tell.
Result<std::uint64_t> end_of_container(ByteSource& bytes, const std::string& file);

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
