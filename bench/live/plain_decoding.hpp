#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"

namespace touchable {

/// What FFmpeg alone needs for the packets of a clip: the plain loop of send and receive, track after track.
/// Of a track of our own codec, which FFmpeg does not decode, it is our decoder's plain loop.
struct PlainDecoding {
    double cpu_ms = 0;   ///< all tracks on one thread: CPU time
    double wall_ms = 0;  ///< each with the threads that FFmpeg takes by itself: wall time
};
/// Of the tracks of these planes, all of their packets, which are read beforehand; the least of some rounds.
Result<PlainDecoding> decode_plainly(const std::filesystem::path& clip, const std::vector<PlaneRole>& planes,
                                     int rounds);

}  // namespace touchable
