#include "engine/authoring/segment_paint.hpp"

#include "engine/authoring/material_guess.hpp"

namespace touchable {

SegmentPaint paint_of(const Segment& segment, std::int32_t of_pixels, const LabelNames& named,
                      const PaletteMaterial* otherwise) {
    if (const auto known = named.find(segment.label); known != named.end()) {
        const NamedSegment& name = known->second;
        return {name.name, name.material, name.feel, name.is_guess};
    }
    const PaletteMaterial* const material =
        otherwise != nullptr ? otherwise
                             : &guess_material({segment.colour, segment.contrast, segment.pixels, of_pixels});
    return {"", std::string(material->name), material->feel(), otherwise == nullptr};
}

}  // namespace touchable
