#include "player/session/painted_choice.hpp"

#include "engine/content/materials/material_clip.hpp"
#include "engine/stop_request.hpp"

namespace touchable {

Result<SegmentStore> read_chosen_segments(const ClipChoice& choice,
                                          const std::function<void(std::int64_t frame)>& progress,
                                          const std::stop_token& given_up) {
    if (choice.is_camera())
        return usage_error(
            "materials are painted on clips, whose segments can be found beforehand; this is a camera");
    const WorkUntil until(given_up);
    ClipChoice own = choice;
    own.shared_clip.reset();
    own.relief.reset();  // heights tell nothing of segments
    own.painted.reset();
    const auto reader = own.open();
    if (!reader.ok()) return reader.error();
    return read_segments(**reader, begin_segments, progress);
}

}  // namespace touchable
