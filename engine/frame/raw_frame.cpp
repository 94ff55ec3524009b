#include "engine/frame/raw_frame.hpp"

#include <cstring>

namespace touchable {

bool same_form(const PlaneView& a, const PlaneView& b) {
    if (a.empty() || b.empty()) return a.empty() && b.empty();
    return a.width == b.width && a.height == b.height && a.bytes_per_sample == b.bytes_per_sample &&
           a.channels == b.channels;
}

bool same_samples(const PlaneView& a, const PlaneView& b) {
    if (!same_form(a, b)) return false;
    if (a.empty() || (a.data == b.data && a.stride == b.stride)) return true;
    const auto row_bytes = static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.channels) *
                           static_cast<std::size_t>(a.bytes_per_sample);
    for (int y = 0; y < a.height; ++y)
        if (std::memcmp(a.row(y), b.row(y), row_bytes) != 0) return false;
    return true;
}

bool same_touch_planes(const RawFrame& a, const RawFrame& b) {
    return same_samples(a.depth, b.depth) && same_samples(a.haptic, b.haptic) &&
           same_samples(a.height, b.height);
}

}  // namespace touchable
