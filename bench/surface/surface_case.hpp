#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/scene/frames.hpp"

namespace touchable {

/// A case of the suite `surface`: what its name tells.
struct SurfaceCase {
    int width, height, bits;
    int holes_pct = 0;  ///< pixels without depth
};
/// <W>x<H>-<bits>, then -holes<percent> where there are any.
std::string name_of(const SurfaceCase& c);
/// Of kind check: what came out in this case is not right.
Error wrong(const SurfaceCase& c, const std::string& what);

/// Depth as cameras give it: a slope with noise, and code 0 where there is none.
struct Picture {
    explicit Picture(const SurfaceCase& c);

    Scene scene;
    std::vector<std::uint8_t> memory;
    RawFrame raw;
};

/// A frame as clips give it, with storage, so that a software Vulkan may read it where it lies. Without one
/// no builder compares it with the frame before; of this one builders are to be told not to. `raw` outlives
/// it.
inline RawFrame kept(RawFrame raw) {
    raw.storage = std::shared_ptr<const void>(std::shared_ptr<void>(), raw.depth.data);
    return raw;
}

/// A surface that stands still in this frame.
inline FramePair still(const SurfaceFrame& frame) {
    return {{0, 0, &frame}, {0, 0, &frame}, 0};
}

}  // namespace touchable
