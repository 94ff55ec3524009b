#pragma once

#include "engine/scene/stored_code.hpp"

namespace touchable {

/// Whether a stored depth picture has any depth; ends at the first pixel that has.
inline bool has_valid_pixel(const PlaneView& depth, const DepthCoding& coding) {
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (coding.is_valid(stored_code(depth, coding, x, y))) return true;
    return false;
}

}  // namespace touchable
