#pragma once

#include <algorithm>
#include <cstdint>

namespace touchable {

/// Element (count - 1)/2 of the sorted codes; reorders them. count >= 1.
inline std::uint16_t lower_median(std::uint16_t* codes, int count) {
    std::uint16_t* middle = codes + (count - 1) / 2;
    std::nth_element(codes, middle, codes + count);
    return *middle;
}

}  // namespace touchable
