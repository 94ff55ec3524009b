#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/frames.hpp"

namespace touchable::test {

/// Fills a slot so that its content can be told from any other's, and checked whole.
inline void fill(SurfaceFrame& frame, std::int64_t content) {
    frame.codes.assign(64, static_cast<std::uint16_t>(content * 7919));
    frame.width = static_cast<int>(content);
}
inline bool holds(const SurfaceFrame& frame, std::int64_t content) {
    return frame.width == content &&
           frame.codes == std::vector<std::uint16_t>(64, static_cast<std::uint16_t>(content * 7919));
}

}  // namespace touchable::test
