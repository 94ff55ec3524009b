#include "engine/scene/surface_frame.hpp"

#include <cassert>
#include <cstring>

namespace touchable {

namespace {

void copy_bytes(const PlaneView& plane, std::vector<std::uint8_t>& out) {
    const auto row_bytes = static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.channels);
    out.resize(row_bytes * static_cast<std::size_t>(plane.height));
    for (int y = 0; y < plane.height; ++y)
        std::memcpy(out.data() + row_bytes * static_cast<std::size_t>(y), plane.row(y), row_bytes);
}

void copy_codes(const PlaneView& plane, std::vector<std::uint16_t>& out) {
    const auto width = static_cast<std::size_t>(plane.width);
    out.resize(width * static_cast<std::size_t>(plane.height));
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint16_t* to = out.data() + width * static_cast<std::size_t>(y);
        if (plane.bytes_per_sample == 2)
            std::memcpy(to, from, width * 2);
        else
            for (std::size_t x = 0; x < width; ++x) to[x] = from[x];
    }
}

}  // namespace

bool has_size(const SurfaceFrame& frame, int width, int height) {
    if (frame.width != width || frame.height != height || !frame.vertices) return false;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return (frame.haptic.empty() || frame.haptic.size() == 3 * pixels) &&
           (frame.heights.empty() || frame.heights.size() == pixels);
}

void copy_touch_planes(const RawFrame& raw, SurfaceFrame& out) {
    // Not cleared first: memory that has the size is not filled with zeros on the way.
    if (raw.haptic.empty()) {
        out.haptic.clear();
    } else {
        assert(raw.haptic.channels == 3 && raw.haptic.bytes_per_sample == 1);
        copy_bytes(raw.haptic, out.haptic);
    }
    if (raw.height.empty()) {
        out.heights.clear();
    } else {
        assert(raw.height.channels == 1);
        copy_codes(raw.height, out.heights);
    }
}

}  // namespace touchable
