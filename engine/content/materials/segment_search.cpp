#include "engine/content/materials/segment_search.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "engine/printable.hpp"
#include "engine/stop_request.hpp"

namespace touchable {
namespace {

std::string in_words(const PixelOfFrame& at) {
    return "pixel " + std::to_string(at.x) + ',' + std::to_string(at.y) + " of frame " +
           std::to_string(at.frame);
}

Error refuse_name(const NamedSegment& name, const std::string& why) {
    return {name.kind, name.said_by + ": " + why};
}

Result<void> check_place(const NamedSegment& name, const ClipReader& clip) {
    const Scene& scene = clip.scene();
    if (name.at->x >= scene.width || name.at->y >= scene.height)
        return refuse_name(name, in_words(*name.at) + " is outside of the picture, which has " +
                                     std::to_string(scene.width) + 'x' + std::to_string(scene.height));
    const auto count = clip.frame_count();
    if (count && name.at->frame >= *count)
        return refuse_name(name, "frame " + std::to_string(name.at->frame) +
                                     " is beyond the clip, whose last one is " + std::to_string(*count - 1));
    return {};
}

/// By index of the map.
Result<std::map<int, NamedSegment>> names_by_index(const SegmentNames& names,
                                                   const std::optional<SegmentMap>& map) {
    std::map<int, NamedSegment> by_index;
    for (const NamedSegment& name : names.segments) {
        if (!name.index) continue;
        if (!map) return refuse_name(name, "has an index, but there is no map");
        if (!by_index.emplace(*name.index, name).second)
            return refuse_name(name, "index " + std::to_string(*name.index) + " is named twice");
    }
    if (map && by_index.empty())
        return usage_error("the map " + map->file +
                           " does nothing: no segment has an index, which says what its values mean");
    return by_index;
}

/// Each segment's pixels by index.
LabelNames names_of_map(const SegmentMap& map, const Segmentation& frame,
                        const std::map<int, NamedSegment>& by_index) {
    std::map<std::uint16_t, std::array<std::int64_t, 256>> counts;
    for (std::size_t k = 0; k < frame.labels.size(); ++k)
        if (frame.labels[k] != 0) ++counts[frame.labels[k]][map.indices.samples[k]];
    LabelNames found;
    for (const Segment& segment : frame.segments) {
        const auto& count = counts[segment.label];
        const auto index = static_cast<int>(std::max_element(count.begin(), count.end()) - count.begin());
        const auto name = by_index.find(index);
        if (name == by_index.end()) continue;
        NamedSegment& named = found.emplace(segment.label, name->second).first->second;
        named.index.reset();
        named.at = PixelOfFrame{segment.x, segment.y, 0};
    }
    return found;
}

/// Puts a name to the segment at its pixel.
Result<void> take_name(const NamedSegment& name, const Segmentation& frame, LabelNames& by_pixel) {
    const auto at = static_cast<std::size_t>(name.at->y) * static_cast<std::size_t>(frame.width) +
                    static_cast<std::size_t>(name.at->x);
    const std::uint16_t label = frame.labels[at];
    if (label == 0)
        return refuse_name(name,
                           "there is no surface at " + in_words(*name.at) + "; name a pixel of the segment");
    const auto [taken, is_new] = by_pixel.emplace(label, name);
    NamedSegment& there = taken->second;
    if (is_new || name.is_guess) return {};
    if (there.is_guess) {
        there = name;
        return {};
    }
    if (!(there.feel == name.feel))
        return refuse_name(name, in_words(*name.at) + " is in the same segment as " + there.said_by +
                                     ", which is " + in_quotes(there.name) +
                                     " and feels different; a segment is of one material");
    return {};
}

}  // namespace

SegmentFrames begin_segments(const Scene& scene) {
    auto segmenter = std::make_shared<Segmenter>(scene);
    return [segmenter](const RawFrame& frame, bool follows) -> const Segmentation& {
        return segmenter->next(frame, follows);
    };
}

Result<LabelNames> find_named_segments(Prefetch& ahead, const SegmentNames& names,
                                       const std::optional<SegmentMap>& map, const BeginSegments& begin) {
    const Scene& scene = ahead.clip().scene();
    if (map && (map->indices.width != scene.width || map->indices.height != scene.height))
        return input_error(map->file + ": has " + std::to_string(map->indices.width) + 'x' +
                           std::to_string(map->indices.height) +
                           " pixels: must have those of the clip's depth, " + std::to_string(scene.width) +
                           'x' + std::to_string(scene.height));
    const auto by_index = names_by_index(names, map);
    if (!by_index) return by_index.error();
    std::vector<const NamedSegment*> wanted;
    for (const NamedSegment& name : names.segments) {
        if (!name.at) continue;
        if (auto fits = check_place(name, ahead.clip()); !fits) return fits.error();
        wanted.push_back(&name);
    }
    std::stable_sort(wanted.begin(), wanted.end(), [](const NamedSegment* a, const NamedSegment* b) {
        return a->at->frame < b->at->frame;
    });
    LabelNames found, by_pixel;
    const SegmentFrames segments_of = begin(scene);
    auto next = wanted.begin();
    for (std::int64_t number = 0; next != wanted.end() || (map && number == 0); ++number) {
        if (stop_requested()) return interrupted_error();
        const auto frame = ahead.next();
        if (!frame) return frame.error();
        if (!*frame)
            return next == wanted.end()
                       ? input_error(ahead.clip().inputs().front().string() + ": has no frames")
                       : refuse_name(**next, "frame " + std::to_string((*next)->at->frame) +
                                                 " is beyond the clip, which has " + std::to_string(number));
        const Segmentation& segmentation = segments_of(**frame, number > 0);
        if (map && number == 0) found = names_of_map(*map, segmentation, *by_index);
        for (; next != wanted.end() && (*next)->at->frame == number; ++next)
            if (auto taken = take_name(**next, segmentation, by_pixel); !taken) return taken.error();
    }
    by_pixel.merge(found);
    return by_pixel;
}

}  // namespace touchable
