#include "engine/clip/frame_check.hpp"

#include <string>

namespace touchable {

Result<void> FrameCheck::check(const RawFrame& frame, const Scene& scene) {
    const std::string number = std::to_string(frame.number);
    const auto misuse = [&](const std::string& what) {
        return Error{ErrorKind::internal, "frame " + number + " given to the clip writer: " + what};
    };
    if (frame.number != frames_) return misuse("number " + std::to_string(frames_) + " was due");
    if (frame.depth.empty()) return misuse("it has no depth");
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(frame, role);
        const std::string name(role_name(role));
        Shape& first = shapes_[static_cast<std::size_t>(role)];
        const Shape shape = plane.empty()
                                ? Shape{}
                                : Shape{plane.width, plane.height, plane.bytes_per_sample, plane.channels};
        if (frames_ == 0) first = shape;
        if (shape != first) return misuse(name + " is of another size or kind than in frame 0");
        if (plane.empty()) continue;
        if (plane.width != scene.width || plane.height != scene.height)
            return misuse(name + " is not of the scene's size");
        if ((role == PlaneRole::colour || role == PlaneRole::haptic) && plane.channels != 3)
            return misuse(name + " is not RGB");
        if (auto fits = check_plane(role, plane, scene, "frame " + number + ", " + name); !fits) return fits;
    }
    ++frames_;
    return {};
}

}  // namespace touchable
