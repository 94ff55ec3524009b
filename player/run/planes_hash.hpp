#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/byte_hash.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// XXH64 over the samples of frames' touch planes (depth, haptic, height) as stored, row by row: what forces
/// depend on, of a clip.
class PlanesHash {
public:
    void add(const RawFrame& frame);
    std::string hex() const { return hash_.hex(); }  ///< 16 digits

private:
    ByteHash hash_;
};

/// Frames of a clip that were read one after another.
struct FrameRun {
    std::int64_t first = 0, count = 0;
    bool operator==(const FrameRun&) const = default;
};

/// Of these frames of a clip, in this order; an error where it has not all of them.
Result<std::string> planes_hash_of(ClipReader& clip, const std::vector<FrameRun>& runs);

}  // namespace touchable
