#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "engine/authoring/segment_names.hpp"
#include "engine/authoring/segment_store.hpp"
#include "engine/authoring/segmentation.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/prefetch.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {

/// Segments of a clip's frames in order, each until the next call; `follows` the frame before.
using SegmentFrames = std::function<const Segmentation&(const RawFrame& frame, bool follows)>;
/// Begins a clip of that scene.
using BeginSegments = std::function<SegmentFrames(const Scene& scene)>;

/// As the program finds them (Segmenter).
SegmentFrames begin_segments(const Scene& scene);

/// A picture of which segment of a clip's first frame is which: `index` of NamedSegment, a byte each.
struct SegmentMap {
    std::string file;
    Image indices;
};

/// Named segments by their label.
using LabelNames = std::map<std::uint16_t, NamedSegment>;

/// Which labels the names mean; cuts do not count. Of a map each segment has the index that most of its
/// pixels have; where a pixel of it is named as well, that counts. Each that is found has a pixel of its own
/// (`at`). Refused: a pixel beyond the picture or without a segment, a frame beyond the clip, one segment
/// under two names that feel different, an index without a map.
Result<LabelNames> find_named_segments(Prefetch& ahead, const SegmentNames& names,
                                       const std::optional<SegmentMap>& map, const BeginSegments& begin);

/// The same of frames that are all known, which are at least one.
Result<LabelNames> find_named_segments(const SegmentStore& segments, const SegmentNames& names,
                                       const std::optional<SegmentMap>& map);

/// The segments with all cuts of the names, one after the other. Refused as SegmentStore::with_cut does,
/// with the number of the cut (ErrorKind::input).
Result<SegmentStore> with_cuts(SegmentStore segments, const SegmentNames& names);

}  // namespace touchable
