#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A picture that serves all frames of a clip.
struct StillPlane {
    PlaneRole role = PlaneRole::haptic;
    Plane plane;                                 ///< of any size: as stored, or resampled already
    TrackInfo info;                              ///< how it is stored
    std::vector<std::filesystem::path> files{};  ///< that it was read from, the one that was named first
    std::vector<std::string> notes{};
    /// Where it changes: the plane in a frame, which fits the scene, by its number and time.
    std::function<Result<Plane>(std::int64_t frame, std::int64_t time_ns)> at{};
};

/// The clip with these planes under every frame, in place of its own of their roles. `scene` is the clip's
/// but for what the planes mean: haptic ranges, height coding and what makes room for heights. Refused where
/// that cannot be, or a plane does not fit it.
Result<std::unique_ptr<ClipReader>> with_still_planes(std::unique_ptr<ClipReader> clip,
                                                      std::vector<StillPlane> planes, const Scene& scene);

}  // namespace touchable
