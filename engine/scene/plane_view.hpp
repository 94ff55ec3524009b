#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace touchable {

/// Samples of one picture as they were decoded, owned by somebody else. Samples of two bytes are in host
/// order.
struct PlaneView {
    const std::uint8_t* data = nullptr;
    std::ptrdiff_t stride = 0;  ///< bytes from one row to the next
    int width = 0, height = 0;
    int bytes_per_sample = 1;  ///< 1 or 2
    int channels = 1;          ///< interleaved: 1, or 3 for red, green, blue

    bool empty() const { return data == nullptr; }
    const std::uint8_t* row(int y) const { return data + stride * y; }
    std::uint16_t sample(int x, int y, int channel = 0) const {
        const std::uint8_t* p =
            row(y) + (static_cast<std::ptrdiff_t>(x) * channels + channel) * bytes_per_sample;
        if (bytes_per_sample == 1) return *p;
        std::uint16_t value;
        std::memcpy(&value, p, 2);
        return value;
    }
};

}  // namespace touchable
