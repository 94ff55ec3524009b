#include "engine/authoring/haptic_track.hpp"

#include <algorithm>
#include <utility>

#include "engine/clip/plane_role.hpp"

namespace touchable {

HapticTrackReader::HapticTrackReader(std::unique_ptr<ClipReader> clip, const HapticRanges& ranges)
    : ReaderAround(std::move(clip)),
      scene_(inner().scene()),
      tracks_(inner().tracks()),
      notes_(inner().notes()) {
    scene_.haptic = ranges;
    const std::string haptic(role_name(PlaneRole::haptic)), height(role_name(PlaneRole::height));
    std::erase_if(tracks_, [&](const TrackInfo& track) { return track.role == haptic; });
    const auto after = std::find_if(tracks_.begin(), tracks_.end(),
                                    [&](const TrackInfo& track) { return track.role == height; });
    tracks_.insert(after, {haptic, "materials of segments", "rgb24", scene_.width, scene_.height, true});
    const auto of_none = default_touch_note(false, inner().scene());
    std::erase_if(notes_, [&](const std::string& note) {
        return note.starts_with(haptic + " is ") || (of_none && note == *of_none);
    });
}

}  // namespace touchable
