#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/mpeg4/boxes.hpp"

namespace touchable::mpeg4 {

/// A sample of a track, such as a picture.
struct Sample {
    std::uint32_t bytes = 0;
    std::uint32_t duration = 0;    ///< until the next is decoded, in the track's time scale
    std::int32_t shown_later = 0;  ///< than it is decoded
    bool is_key = true;            ///< decoding can begin with it
};
/// Samples that stand one behind the other in the file.
struct Chunk {
    std::uint64_t at = 0;
    std::uint32_t samples = 0;
    std::uint32_t description = 1;  ///< which entry of the track's stsd
};
/// All of a track, in the order of decoding.
struct TrackSamples {
    std::vector<Sample> samples;
    std::vector<Chunk> chunks;
};

/// What a track's tables say (box stbl); nothing where they are empty. An error where they contradict each
/// other or have more than `most`.
Result<TrackSamples> samples_in(BytesView stbl, std::size_t most);
/// The tables of these samples, which stand in a file so many bytes later: all boxes of a stbl but its stsd.
Bytes tables_of(const TrackSamples& track, std::uint64_t later);

}  // namespace touchable::mpeg4
