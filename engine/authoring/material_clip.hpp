#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/authoring/segment_paint.hpp"
#include "engine/authoring/segment_search.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

struct MaterialSettings {
    SegmentNames names{};
    std::optional<SegmentMap> map{};
    /// Heights (8 bits, 128 is level, as with_relief makes them) are scaled by each material's relief.
    bool scale_relief = false;
    /// That the haptic pictures have; values beyond are cut. Nothing: some that hold all (ranges_of_palette).
    std::optional<HapticRanges> ranges{};
};

/// A segment as it was seen first.
struct SeenSegment {
    std::uint16_t label = 0;
    PixelOfFrame at{};  ///< a pixel of it
    std::int32_t pixels = 0;
    std::array<std::uint8_t, 3> colour{};
    SegmentPaint paint{};
};

/// What was found in the frames read since the clip's beginning.
struct MaterialReport {
    std::vector<SeenSegment> segments;  ///< in the order in which they came
    std::int64_t frames = 0;
    /// Pixels with a segment in two frames that follow each other, and those whose segment is another one.
    std::int64_t compared = 0, changed = 0;
    double seconds = 0;  ///< that segments and haptic pictures took
};

/// The segments of all frames of a clip, which is at its beginning; it is at its end then. `progress`, if
/// any, is called before each frame with its number. Refused: a frame that cannot be read; no frames; more
/// segments than fit into 1 GiB.
Result<SegmentStore> read_segments(ClipReader& clip, const BeginSegments& begin,
                                   const std::function<void(std::int64_t frame)>& progress);

/// The clip with haptic pictures in place of its own, in which each segment feels like its material: as it
/// is named, otherwise as its first look suggests. A segment keeps its material. The report is filled as
/// frames are read. Seeking reads all frames from the first on, since segments are followed; where
/// segments are cut all are read once before. Refused as find_named_segments and with_cuts do; a frame is
/// where its colour is needed for a guess, and where its heights cannot be scaled.
Result<std::unique_ptr<ClipReader>> with_materials(std::unique_ptr<ClipReader> clip,
                                                   const MaterialSettings& settings,
                                                   const BeginSegments& begin,
                                                   std::shared_ptr<MaterialReport> report);

}  // namespace touchable
