#pragma once

#include <array>
#include <cstdint>

#include "engine/base/result.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What whoever writes a clip may count on (ClipWriter::write): frames in order, with depth, all with the
/// planes of the first one, of the scene's size and of samples that the scene allows.
class FrameCheck {
public:
    /// An error of kind internal where a caller breaks that, of kind input where a sample does.
    Result<void> check(const RawFrame& frame, const Scene& scene);
    /// That passed.
    std::int64_t frames() const { return frames_; }
    /// Of the plane in each of them; 0 where there is none.
    int bytes_per_sample(PlaneRole role) const {
        return shapes_[static_cast<std::size_t>(role)].bytes_per_sample;
    }

private:
    /// What stays the same from frame to frame; all zero for a plane that is not there.
    struct Shape {
        int width = 0, height = 0, bytes_per_sample = 0, channels = 0;
        bool operator==(const Shape&) const = default;
    };

    std::array<Shape, all_roles.size()> shapes_;
    std::int64_t frames_ = 0;
};

}  // namespace touchable
