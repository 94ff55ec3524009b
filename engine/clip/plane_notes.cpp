#include "engine/clip/plane_notes.hpp"

#include <utility>

#include "engine/clip/codecs.hpp"
#include "engine/clip/plane_role.hpp"

namespace touchable {

std::vector<std::string> describe_planes(const std::vector<TrackInfo>& tracks, const RawFrame& first,
                                         Scene& scene) {
    std::vector<std::string> notes;
    bool has_haptic = false;
    for (const TrackInfo& track : tracks) {
        const PlaneRole role = role_named(track.role).value_or(PlaneRole::depth);
        has_haptic = has_haptic || role == PlaneRole::haptic;
        if (role == PlaneRole::haptic && track.pixel_format.starts_with("gray"))
            notes.push_back(take_grey_haptic(scene));
        if (track.width != scene.width || track.height != scene.height)
            notes.push_back(resampling_note(role, track.width, track.height, scene));
        if (track.lossless) continue;
        if (auto note = lossy_note(role, track.codec)) notes.push_back(std::move(*note));
    }
    if (auto note = no_depth_note(first, scene.depth)) notes.push_back(std::move(*note));
    if (auto note = default_touch_note(has_haptic, scene)) notes.push_back(std::move(*note));
    return notes;
}

}  // namespace touchable
