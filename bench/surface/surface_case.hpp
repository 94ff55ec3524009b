// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/scene/frames.hpp"

namespace touchable {

/// A case of the suite `surface`, as described by its name.
struct SurfaceCase {
    int width, height, bits;
    int holes_pct = 0;  ///< pixels without depth
};
/// <W>x<H>-<bits>, then -holes<percent> if there are any.
std::string name_of(const SurfaceCase& c);
/// An error of kind check: a wrong result in this case.
Error wrong(const SurfaceCase& c, const std::string& what);

/// Depth like a camera's: a slope with noise; code 0: no depth.
struct Picture {
    explicit Picture(const SurfaceCase& c);

    Scene scene;
    std::vector<std::uint8_t> memory;
    RawFrame raw;
};

/// A frame with storage, like a clip's. Without storage builders do not compare a frame with the previous
/// one; with this frame comparing must be disabled. `raw` must outlive it.
inline RawFrame kept(RawFrame raw) {
    raw.storage = std::shared_ptr<const void>(std::shared_ptr<void>(), raw.depth.data);
    return raw;
}

/// A still surface: a pair of this frame.
inline FramePair still(const SurfaceFrame& frame) {
    return {{0, 0, &frame}, {0, 0, &frame}, 0};
}

}  // namespace touchable
