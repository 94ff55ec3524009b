// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"

namespace touchable {

/// Time that FFmpeg alone needs for the packets of a clip: the plain loop of send and receive, track after
/// track. For a track in our own codec, which FFmpeg cannot decode: our decoder's plain loop.
struct PlainDecoding {
    double cpu_ms = 0;   ///< CPU time, all tracks on one thread
    double wall_ms = 0;  ///< wall time, each track with FFmpeg's default threads
};
/// Decodes all packets of these planes' tracks, read beforehand; the least time of `rounds`.
Result<PlainDecoding> decode_plainly(const std::filesystem::path& clip, const std::vector<PlaneRole>& planes,
                                     int rounds);

}  // namespace touchable
