#include "engine/authoring/segment_search.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

std::string in_words(const PixelOfFrame& at) {
    return "pixel " + std::to_string(at.x) + ',' + std::to_string(at.y) + " of frame " +
           std::to_string(at.frame);
}

Error refuse_name(const NamedSegment& name, const std::string& why) {
    return {name.kind, name.said_by + ": " + why};
}

/// A pixel that somebody named.
struct NamedPlace {
    const NamedSegment* name;
    PixelOfFrame at;
};

Result<void> check_place(const NamedPlace& place, const Segmentation& size,
                         std::optional<std::int64_t> frames) {
    if (place.at.x >= size.width || place.at.y >= size.height)
        return refuse_name(*place.name, in_words(place.at) + " is outside of the picture, which has " +
                                            std::to_string(size.width) + 'x' + std::to_string(size.height));
    if (frames && place.at.frame >= *frames)
        return refuse_name(*place.name, "frame " + std::to_string(place.at.frame) +
                                            " is beyond the clip, whose last one is " +
                                            std::to_string(*frames - 1));
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
Result<LabelNames> names_of_map(const SegmentMap& map, const Segmentation& frame,
                                const std::map<int, NamedSegment>& by_index) {
    std::map<std::uint16_t, std::array<std::int64_t, 256>> counts;
    for (std::size_t k = 0; k < frame.labels.size(); ++k)
        if (frame.labels[k] != 0) ++counts[frame.labels[k]][map.indices.samples[k]];
    LabelNames found;
    std::set<int> used;
    for (const Segment& segment : frame.segments) {
        const auto& count = counts[segment.label];
        const auto index = static_cast<int>(std::max_element(count.begin(), count.end()) - count.begin());
        const auto name = by_index.find(index);
        if (name == by_index.end()) continue;
        NamedSegment& named = found.emplace(segment.label, name->second).first->second;
        named.index.reset();
        named.at = {{segment.x, segment.y, 0}};
        used.insert(index);
    }
    for (const auto& [index, name] : by_index)
        if (!used.contains(index))
            return refuse_name(name, "no segment has most of its pixels where " + map.file + " has index " +
                                         std::to_string(index));
    return found;
}

/// Puts a name to the segment at one of its pixels.
Result<void> take_name(const NamedPlace& place, const Segmentation& frame, LabelNames& by_pixel) {
    const NamedSegment& name = *place.name;
    const auto at = static_cast<std::size_t>(place.at.y) * static_cast<std::size_t>(frame.width) +
                    static_cast<std::size_t>(place.at.x);
    const std::uint16_t label = frame.labels[at];
    if (label == 0)
        return refuse_name(name,
                           "there is no surface at " + in_words(place.at) + "; name a pixel of the segment");
    const auto [taken, is_new] = by_pixel.emplace(label, name);
    NamedSegment& there = taken->second;
    if (is_new || name.is_guess) return {};
    // What is said on the command line counts before what a file says.
    const bool is_typed = name.kind == ErrorKind::usage, was_typed = there.kind == ErrorKind::usage;
    if (there.is_guess || (is_typed && !was_typed)) {
        there = name;
        return {};
    }
    if (was_typed && !is_typed) return {};
    if (!(there.feel == name.feel))
        return refuse_name(name, in_words(place.at) + " is in the same segment as " + there.said_by +
                                     ", which is " + in_quotes(there.name) +
                                     " and feels different; a segment is of one material");
    return {};
}

/// Looks at frames in order, as far as somebody named something there.
class NameSearch {
public:
    NameSearch(const SegmentNames& names, const std::optional<SegmentMap>& map, const Segmentation& size)
        : names_(names), map_(map), size_(size) {}

    /// Before the first frame; nothing: nobody knows how many there are.
    Result<void> begin(std::optional<std::int64_t> frames);
    /// The place that is looked for next; null: none is.
    const NamedPlace* next() const { return next_ < places_.size() ? &places_[next_] : nullptr; }
    bool wants_map() const { return map_.has_value(); }
    Result<void> look(const Segmentation& segmentation, std::int64_t frame);
    LabelNames take_found() {
        by_pixel_.merge(found_);
        return std::move(by_pixel_);
    }

private:
    const SegmentNames& names_;
    const std::optional<SegmentMap>& map_;
    const Segmentation size_;
    std::map<int, NamedSegment> by_index_;
    std::vector<NamedPlace> places_;
    std::size_t next_ = 0;
    LabelNames found_, by_pixel_;  // by the map, and by pixels
};

Result<void> NameSearch::begin(std::optional<std::int64_t> frames) {
    if (map_ && (map_->indices.width != size_.width || map_->indices.height != size_.height))
        return input_error(map_->file + ": has " + std::to_string(map_->indices.width) + 'x' +
                           std::to_string(map_->indices.height) +
                           " pixels: must have those of the clip's depth, " + std::to_string(size_.width) +
                           'x' + std::to_string(size_.height));
    TRY_ASSIGN(auto by_index, names_by_index(names_, map_));
    by_index_ = std::move(by_index);
    for (const NamedSegment& name : names_.segments)
        for (const PixelOfFrame& at : name.at) {
            places_.push_back({&name, at});
            if (auto fits = check_place(places_.back(), size_, frames); !fits) return fits;
        }
    std::stable_sort(places_.begin(), places_.end(),
                     [](const NamedPlace& a, const NamedPlace& b) { return a.at.frame < b.at.frame; });
    return {};
}

Result<void> NameSearch::look(const Segmentation& segmentation, std::int64_t frame) {
    if (map_ && frame == 0) {
        TRY_ASSIGN(auto of_map, names_of_map(*map_, segmentation, by_index_));
        found_ = std::move(of_map);
    }
    for (; next() && next()->at.frame == frame; ++next_)
        if (auto taken = take_name(*next(), segmentation, by_pixel_); !taken) return taken;
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
    NameSearch search(names, map, {scene.width, scene.height, {}, {}});
    TRY(search.begin(ahead.clip().frame_count()));
    const SegmentFrames segments_of = begin(scene);
    for (std::int64_t number = 0; search.next() || (search.wants_map() && number == 0); ++number) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(const auto frame, ahead.next());
        if (!frame)
            return search.next() ? refuse_name(*search.next()->name,
                                               "frame " + std::to_string(search.next()->at.frame) +
                                                   " is beyond the clip, which has " + std::to_string(number))
                                 : input_error(ahead.clip().inputs().front().string() + ": has no frames");
        TRY(search.look(segments_of(*frame, number > 0), number));
    }
    return search.take_found();
}

Result<LabelNames> find_named_segments(const SegmentStore& segments, const SegmentNames& names,
                                       const std::optional<SegmentMap>& map) {
    NameSearch search(names, map, {segments.width(), segments.height(), {}, {}});
    TRY(search.begin(segments.frames()));
    for (std::int64_t number = 0; search.next() || (search.wants_map() && number == 0); ++number)
        if ((search.next() && search.next()->at.frame == number) || number == 0)
            TRY(search.look(segments.segmentation(number), number));
    return search.take_found();
}

Result<SegmentStore> with_cuts(SegmentStore segments, const SegmentNames& names) {
    for (std::size_t k = 0; k < names.cuts.size(); ++k) {
        auto made = segments.with_cut(names.cuts[k]);
        if (!made)
            return input_error(names.said_by + ": cuts[" + std::to_string(k) + "]: " + made.error().message);
        segments = std::move(*made);
    }
    return segments;
}

}  // namespace touchable
