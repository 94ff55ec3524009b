#include "engine/media/far_plane.hpp"

#include <algorithm>

#include "engine/stop_request.hpp"

namespace touchable {

Result<void> FarPlaneSearch::add(const PlaneView& depth) {
    if (stop_requested())
        return Error{ErrorKind::internal, "interrupted while the clip's far plane was searched"};
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) {
            const int code = depth.sample(x, y);
            if (code > deepest_ && coding_.is_valid(static_cast<std::uint16_t>(code))) deepest_ = code;
        }
    return {};
}

Result<std::string> FarPlaneSearch::settle(Scene& scene) const {
    if (deepest_ < 0) return input_error("no frame has a valid depth: give depth.far in the scene file");
    const double deepest = coding_.depth(static_cast<std::uint16_t>(deepest_));
    scene.depth.far = deepest * 1.05;
    scene.far_from_frames = false;
    derive_valid_range(scene.depth);
    if (auto valid = validate(scene); !valid) return valid.error();
    return "depth.far is " + std::to_string(scene.depth.far) + ": the frames' largest depth, " +
           std::to_string(deepest) + ", plus 5 %";
}

}  // namespace touchable
