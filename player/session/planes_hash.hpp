#pragma once

#include <cstdint>
#include <string>

#include "engine/byte_hash.hpp"
#include "engine/frame/raw_frame.hpp"
#include "engine/media/clip.hpp"
#include "engine/result.hpp"

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

/// Of a clip's next `frames`; of all it has where those are fewer.
Result<std::string> planes_hash_of(ClipReader& clip, std::int64_t frames);

}  // namespace touchable
