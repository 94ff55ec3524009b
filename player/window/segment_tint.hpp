#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/authoring/material_brush.hpp"
#include "engine/scene/plane_view.hpp"

namespace touchable {

/// A picture of a frame's segments: each in the colour of its material over the brightness that the clip has
/// there, with dark lines between them. Holes are dark.
class SegmentTint {
public:
    /// RGB, of the depth plane's size; stays as it is until the next call. `colour`: the clip's, of any size,
    /// or empty. Of a frame beyond the segments' last: that one's. What was painted last is not painted again
    /// for the same segments, frame and place of colour in memory.
    PlaneView paint(const std::shared_ptr<const PaintedSegments>& painted, std::int64_t frame,
                    const PlaneView& colour);

private:
    void paint_anew(const PlaneView& colour);

    std::shared_ptr<const PaintedSegments> painted_;  // what `rgb_` is of
    std::int64_t frame_ = -1;
    const void* colour_ = nullptr;
    std::vector<std::uint16_t> labels_;
    std::vector<std::uint8_t> rgb_;
};

}  // namespace touchable
