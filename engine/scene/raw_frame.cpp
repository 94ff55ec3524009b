#include "engine/scene/raw_frame.hpp"

#include <cstring>

namespace touchable {

RawFrame kept_frame(const RawFrame& frame) {
    if (frame.storage) return frame;
    RawFrame kept = frame;
    std::size_t bytes = 0;
    PlaneView* const planes[] = {&kept.depth, &kept.colour, &kept.haptic, &kept.height};
    const auto row_bytes = [](const PlaneView& plane) {
        return static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.channels) *
               static_cast<std::size_t>(plane.bytes_per_sample);
    };
    // Samples of two bytes stay at even places.
    const auto room = [&](const PlaneView& plane) {
        return plane.empty() ? 0 : (row_bytes(plane) * static_cast<std::size_t>(plane.height) + 1) / 2 * 2;
    };
    for (const PlaneView* plane : planes) bytes += room(*plane);
    const auto storage = std::make_shared<std::vector<std::uint8_t>>(bytes);
    std::uint8_t* to = storage->data();
    for (PlaneView* plane : planes) {
        if (plane->empty()) continue;
        const PlaneView from = *plane;
        plane->data = to;
        plane->stride = static_cast<std::ptrdiff_t>(row_bytes(from));
        for (int y = 0; y < from.height; ++y)
            std::memcpy(to + static_cast<std::size_t>(y) * row_bytes(from), from.row(y), row_bytes(from));
        to += room(from);
    }
    kept.storage = storage;
    return kept;
}

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
