#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/base/byte_source.hpp"
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

}  // namespace touchable
