#pragma once

#include <cstddef>
#include <vector>

#include "player/draw/view_surface.hpp"

namespace touchable {

/// What a painter gives: z (see ViewCamera; 0: nothing drawn) and colour of every pixel, row-major.
struct PicturePlanes {
    int width = 0, height = 0;
    std::vector<float> z;
    std::vector<PackedColour> colours;  ///< undefined where nothing is drawn

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

}  // namespace touchable
