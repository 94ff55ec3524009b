#pragma once

#include <algorithm>
#include <cstdint>

namespace touchable {

/// How stored codes become those that filters work on: `factor` times as many, so that a mean of two has
/// somewhere to lie. Or fewer, where levels are farther apart than codes and codes too large for 15 bits: a
/// 2^shift-th of them, rounded, 0 only for 0. One of the two does nothing.
struct CodeScale {
    int factor = 1, shift = 0;

    std::uint16_t of(int code) const {
        if (shift == 0) return static_cast<std::uint16_t>(code * factor);
        return static_cast<std::uint16_t>(std::max(((code >> (shift - 1)) + 1) >> 1, std::min(code, 1)));
    }
    bool operator==(const CodeScale&) const = default;
};

}  // namespace touchable
