#pragma once

#include <memory>
#include <optional>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"
#include "engine/mpeg4/boxes.hpp"

namespace touchable::mpeg4 {

// A fragmented MP4 file (ISO/IEC 14496-12, 8.8) tells of its samples stretch by stretch, each in a box moof
// of its own, so that it can be read while it is written, and up to where it was cut.

/// The pictures of such a file, as a plain file would have them.
struct GatheredMovie {
    Bytes head;              ///< what stands before the file's own bytes, all of which are samples then
    std::uint64_t size = 0;  ///< of the file
    bool is_cut = false;     ///< it ends in the middle of a box
};
/// Of all fragments whose samples are there; nothing where the file's movie box speaks of none (mvex).
Result<std::optional<GatheredMovie>> gather_fragments(ByteSource& file);

/// The plain file.
std::unique_ptr<ByteSource> plain_file(const GatheredMovie& movie, std::unique_ptr<ByteSource> file);

}  // namespace touchable::mpeg4
