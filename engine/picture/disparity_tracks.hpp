#pragma once

#include <memory>
#include <vector>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// iPhone's Cinematic videos have a track of disparity: HEVC, but its sample entry is called `dish`, which
/// FFmpeg does not know.
struct DisparityTracks {
    std::vector<int> ids;                 ///< of the tracks, as their tkhd has them; none: it has none
    std::vector<std::uint64_t> names_at;  ///< of the bytes `dish`
};
/// Of QuickTime, up to `end`.
Result<DisparityTracks> find_disparity_tracks(ByteSource& bytes, std::uint64_t end);
/// The same bytes with `hvc1` in place of each of these names.
std::unique_ptr<ByteSource> shown_as_hevc(std::unique_ptr<ByteSource> bytes,
                                          std::vector<std::uint64_t> names_at);

}  // namespace touchable
