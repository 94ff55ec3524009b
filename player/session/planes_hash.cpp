#include "player/session/planes_hash.hpp"

namespace touchable {

void PlanesHash::add(const RawFrame& frame) {
    for (const PlaneView* plane : {&frame.depth, &frame.haptic, &frame.height}) {
        if (plane->empty()) continue;
        const auto row_bytes = static_cast<std::size_t>(plane->width) *
                               static_cast<std::size_t>(plane->channels) *
                               static_cast<std::size_t>(plane->bytes_per_sample);
        for (int y = 0; y < plane->height; ++y) hash_.add(plane->row(y), row_bytes);
    }
}

Result<std::string> planes_hash_of(ClipReader& clip, std::int64_t frames) {
    PlanesHash hash;
    for (std::int64_t number = 0; number < frames; ++number) {
        const auto frame = clip.next();
        if (!frame.ok()) return frame.error();
        if (!*frame) break;
        hash.add(**frame);
    }
    return hash.hex();
}

}  // namespace touchable
