#pragma once

#include <cstdint>
#include <string>

#include "engine/authoring/palette.hpp"
#include "engine/authoring/segment_search.hpp"

namespace touchable {

/// What a segment is like, and who says so.
struct SegmentPaint {
    std::string name{};      ///< empty: nobody gave it one
    std::string material{};  ///< of the palette; empty: values of its own
    Feel feel{};
    bool is_guess = false;
};

/// Of a segment as it was seen first, in a picture of so many pixels: as it is named, otherwise as all others
/// are; null: as its look suggests.
SegmentPaint paint_of(const Segment& segment, std::int32_t of_pixels, const LabelNames& named,
                      const PaletteMaterial* otherwise);

}  // namespace touchable
