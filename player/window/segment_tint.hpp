#pragma once

#include <cstdint>
#include <vector>

#include "engine/content/materials/material_brush.hpp"
#include "engine/frame/plane_view.hpp"

namespace touchable {

/// A picture of a frame's segments: each in the colour of its material over the brightness that the clip has
/// there, with dark lines between them. Holes are dark.
class SegmentTint {
public:
    /// RGB, of the depth plane's size; stays as it is until the next call. `colour`: the clip's, of any size,
    /// or empty. Of a frame beyond the segments' last: that one's.
    PlaneView paint(const PaintedSegments& painted, std::int64_t frame, const PlaneView& colour);

private:
    std::vector<std::uint16_t> labels_;
    std::vector<std::uint8_t> rgb_;
};

}  // namespace touchable
