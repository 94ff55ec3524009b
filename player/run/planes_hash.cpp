#include "player/run/planes_hash.hpp"

#include "engine/base/try.hpp"

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

Result<std::string> planes_hash_of(ClipReader& clip, const std::vector<FrameRun>& runs) {
    PlanesHash hash;
    for (const FrameRun& run : runs) {
        TRY(clip.seek(run.first));
        for (std::int64_t k = 0; k < run.count; ++k) {
            TRY_ASSIGN(const auto frame, clip.next());
            if (!frame) return input_error("the clip has no frame " + std::to_string(run.first + k));
            hash.add(*frame);
        }
    }
    return hash.hex();
}

}  // namespace touchable
