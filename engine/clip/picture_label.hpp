#pragma once

#include <cstdint>

namespace touchable {

/// What a stream says beside each picture (docs/streaming.md), so that pictures of one moment are known
/// whatever became of their times on the way.
struct PictureLabel {
    std::int64_t frame = 0;     ///< of the stream: counts up, also from one round of a loop to the next
    std::int64_t taken_ns = 0;  ///< by the sender's clock, ns since 1970 (UTC); 0: not known
    bool operator==(const PictureLabel&) const = default;
};

}  // namespace touchable
