#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "engine/authoring/segment_paint.hpp"
#include "engine/authoring/segment_store.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// What all segments of a clip are like: of one moment, never changed.
struct PaintedSegments {
    std::shared_ptr<const SegmentStore> segments;
    using Paint = SegmentPaint;
    std::map<std::uint16_t, Paint> by_label{};  ///< of all that are seen anywhere
};

/// The clip with haptic pictures in place of its own, in which each segment feels as painted: those that
/// with_materials makes of the same names. Any frame at once. Refused (ErrorKind::usage) where the clip has
/// not the segments' size, and for a live source.
Result<std::unique_ptr<ClipReader>> with_painted_segments(std::unique_ptr<ClipReader> clip,
                                                          std::shared_ptr<const PaintedSegments> painted);

}  // namespace touchable
