#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/scene/frames.hpp"

namespace touchable::test {

/// Every channel another, every pixel another.
struct ManyColours {
    ManyColours(int columns, int rows) : width(columns), height(rows) {
        for (int k = 0; k < width * height * 3; ++k) bytes.push_back(static_cast<std::uint8_t>(k * 89 % 251));
    }
    PlaneView view() const { return {bytes.data(), std::ptrdiff_t{3} * width, width, height, 1, 3}; }

    int width, height;
    std::vector<std::uint8_t> bytes;
};

}  // namespace touchable::test
