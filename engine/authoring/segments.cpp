// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/segments.hpp"

#include <set>

#include "engine/authoring/segment_parts.hpp"
#include "engine/authoring/segmentation.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {

namespace {

constexpr std::size_t longest_run = 65535, last_label = 65535;

/// Where the look of that label is, or would be, among looks by ascending label.
auto place_of_look(auto& seen, std::uint16_t label) {
    return std::ranges::lower_bound(seen, label, {}, [](const auto& look) { return look.segment.label; });
}

/// A pixel amid a label's longest run in a row, and the number of its pixels.
struct PlaceOfLabel {
    std::int32_t x = 0, y = 0, pixels = 0;
};
PlaceOfLabel place_of_label(const std::vector<std::uint16_t>& labels, int width, std::uint16_t label) {
    PlaceOfLabel place;
    int longest = 0, run = 0;
    for (std::size_t k = 0; k < labels.size(); ++k) {
        const auto x = static_cast<int>(k % static_cast<std::size_t>(width));
        if (x == 0) run = 0;
        run = labels[k] == label ? run + 1 : 0;
        place.pixels += labels[k] == label;
        if (run <= longest) continue;
        longest = run;
        place.x = x - run / 2;
        place.y = static_cast<int>(k / static_cast<std::size_t>(width));
    }
    return place;
}

std::string in_words(const PixelOfFrame& at) {
    return "pixel " + std::to_string(at.x) + ',' + std::to_string(at.y) + " of frame " +
           std::to_string(at.frame);
}

Error refuse_name(const NamedSegment& name, const std::string& why) {
    return {name.kind, name.said_by + ": " + why};
}

/// A pixel that has a name.
struct NamedPlace {
    const NamedSegment* name;
    PixelOfFrame at;
};

Result<void> check_place(const NamedPlace& place, const Segmentation& size,
                         std::optional<std::int64_t> frames) {
    if (place.at.x >= size.width || place.at.y >= size.height)
        return refuse_name(*place.name, in_words(place.at) + " is outside of the picture, which has " +
                                            size_text(size.width, size.height));
    if (frames && place.at.frame >= *frames)
        return refuse_name(*place.name, "frame " + std::to_string(place.at.frame) +
                                            " is beyond the clip, whose last one is " +
                                            std::to_string(*frames - 1));
    return {};
}

/// Names by index of the map.
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

/// Names each segment by the index of most of its pixels.
Result<LabelNames> names_of_map(const SegmentMap& map, const Segmentation& frame,
                                const std::map<int, NamedSegment>& by_index) {
    std::map<std::uint16_t, std::array<std::int64_t, 256>> counts;
    for (std::size_t k = 0; k < frame.labels.size(); ++k)
        if (frame.labels[k] != 0) ++counts[frame.labels[k]][map.indices.samples[k]];
    LabelNames found;
    std::set<int> used;
    for (const Segment& segment : frame.segments) {
        const auto& count = counts[segment.label];
        const auto index = static_cast<int>(std::ranges::max_element(count) - count.begin());
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

/// Names the segment at one of its pixels.
Result<void> take_name(const NamedPlace& place, const Segmentation& frame, LabelNames& by_pixel) {
    const NamedSegment& name = *place.name;
    const auto at = pixel_place(place.at.x, place.at.y, frame.width);
    const std::uint16_t label = frame.labels[at];
    if (label == 0)
        return refuse_name(name,
                           "there is no surface at " + in_words(place.at) + "; name a pixel of the segment");
    const auto [taken, is_new] = by_pixel.emplace(label, name);
    NamedSegment& there = taken->second;
    if (is_new || name.is_guess) return {};
    // Names of the command line take precedence over those of a file.
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

/// Looks at frames in order, up to the last one with a named pixel.
class NameSearch {
public:
    NameSearch(const SegmentNames& names, const std::optional<SegmentMap>& map, const Segmentation& size)
        : names_(names), map_(map), size_(size) {}

    /// To be called before the first frame; nullopt: the number of frames is not known.
    Result<void> begin(std::optional<std::int64_t> frames) {
        if (map_ && (map_->indices.width != size_.width || map_->indices.height != size_.height))
            return input_error(map_->file + ": has " + size_text(map_->indices.width, map_->indices.height) +
                               " pixels: must have those of the clip's depth, " +
                               size_text(size_.width, size_.height));
        TRY_ASSIGN(by_index_, names_by_index(names_, map_));
        for (const NamedSegment& name : names_.segments)
            for (const PixelOfFrame& at : name.at) {
                places_.push_back({&name, at});
                TRY(check_place(places_.back(), size_, frames));
            }
        std::ranges::stable_sort(places_, {}, [](const NamedPlace& place) { return place.at.frame; });
        return {};
    }

    /// The next place to look for; null: none.
    const NamedPlace* next() const { return next_ < places_.size() ? &places_[next_] : nullptr; }
    bool wants_map() const { return map_.has_value(); }
    Result<void> look(const Segmentation& segmentation, std::int64_t frame) {
        if (map_ && frame == 0) TRY(assign(found_, names_of_map(*map_, segmentation, by_index_)));
        for (; next() && next()->at.frame == frame; ++next_) TRY(take_name(*next(), segmentation, by_pixel_));
        return {};
    }

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

}  // namespace

SegmentStore::Runs SegmentStore::runs_of(const std::vector<std::uint16_t>& labels) {
    std::vector<Run> runs;
    for (const std::uint16_t label : labels) {
        if (runs.empty() || runs.back().label != label || runs.back().pixels == longest_run)
            runs.push_back({label, 0});
        ++runs.back().pixels;
    }
    runs.shrink_to_fit();
    return std::make_shared<const std::vector<Run>>(std::move(runs));
}

void SegmentStore::add(const Segmentation& frame) {
    for (const Segment& segment : frame.segments)
        if (!find(segment.label)) seen_.insert(place_of_look(seen_, segment.label), {frames(), segment});
    frames_.push_back(runs_of(frame.labels));
    bytes_ += frames_.back()->size() * sizeof(Run);
}

std::string SegmentStore::fingerprint() const {
    ByteHash hash;
    hash.add(&width_, sizeof width_);
    hash.add(&height_, sizeof height_);
    for (const Runs& runs : frames_) {
        hash.add(runs->data(), runs->size() * sizeof(Run));
        hash.add("", 1);  // the frame's end
    }
    return hash.hex();
}

void SegmentStore::read_labels(std::int64_t frame, std::vector<std::uint16_t>& labels) const {
    labels.clear();
    for (const Run& run : *frames_[static_cast<std::size_t>(frame)])
        labels.insert(labels.end(), run.pixels, run.label);
}

std::uint16_t SegmentStore::label_at(std::int64_t frame, int x, int y) const {
    auto left = static_cast<std::int64_t>(y) * width_ + x;  // pixels before it, still to be passed
    for (const Run& run : *frames_[static_cast<std::size_t>(frame)]) {
        left -= run.pixels;
        if (left < 0) return run.label;
    }
    return 0;
}

Segmentation SegmentStore::segmentation(std::int64_t frame) const {
    Segmentation found{width_, height_, {}, {}};
    read_labels(frame, found.labels);
    std::vector<bool> is_there(last_label + 1);
    for (const Run& run : *frames_[static_cast<std::size_t>(frame)]) is_there[run.label] = true;
    for (const FirstLook& look : seen_)
        if (is_there[look.segment.label]) found.segments.push_back(look.segment);
    return found;
}

const SegmentStore::FirstLook* SegmentStore::find(std::uint16_t label) const {
    const auto at = place_of_look(seen_, label);
    return at == seen_.end() || at->segment.label != label ? nullptr : &*at;
}

std::int64_t SegmentStore::last_frame_of(std::uint16_t label) const {
    std::int64_t frame = frames() - 1;
    while (frame > 0 && !has(frame, label)) --frame;
    return frame;
}

bool SegmentStore::has(std::int64_t frame, std::uint16_t label) const {
    const auto& runs = *frames_[static_cast<std::size_t>(frame)];
    return std::ranges::any_of(runs, [&](const Run& run) { return run.label == label; });
}

/// Cuts the frames beyond `from`, in the direction of `step`.
Result<void> SegmentStore::follow(CutFollower follower, std::int64_t from, std::int64_t step,
                                  std::uint16_t label) {
    std::vector<std::uint16_t> labels;
    for (std::int64_t frame = from + step; frame >= 0 && frame < frames(); frame += step) {
        if (stop_requested()) return interrupted_error();
        if (!has(frame, label)) continue;
        read_labels(frame, labels);
        follower.next(labels);
        frames_[static_cast<std::size_t>(frame)] = runs_of(labels);
    }
    return {};
}

/// Finds where a part of a segment is seen first, since the other part may have the whole's first look.
void SegmentStore::look_again(std::uint16_t label, const FirstLook& whole) {
    std::int64_t frame = whole.frame;
    while (frame < frames() && !has(frame, label)) ++frame;
    std::vector<std::uint16_t> labels;
    FirstLook look{frame, whole.segment};
    if (frame < frames()) read_labels(frame, labels);
    const PlaceOfLabel place = place_of_label(labels, width_, label);
    look.segment.label = label;
    look.segment.x = place.x;
    look.segment.y = place.y;
    look.segment.pixels = place.pixels;
    const auto at = place_of_look(seen_, label);
    if (find(label))
        *at = look;
    else
        seen_.insert(at, look);
}

Result<SegmentStore> SegmentStore::with_cut(const SegmentCut& cut) const {
    if (cut.frame < 0 || cut.frame >= frames())
        return usage_error("the stroke is on frame " + std::to_string(cut.frame) +
                           ", but the clip's last one is " + std::to_string(frames() - 1));
    for (const SegmentCut::Point& point : cut.stroke)
        if (point.x < 0 || point.y < 0 || point.x >= width_ || point.y >= height_)
            return usage_error("the stroke leads out of the picture, to pixel " + std::to_string(point.x) +
                               ',' + std::to_string(point.y) + ", which has " + size_text(width_, height_));
    std::vector<std::uint16_t> labels;
    read_labels(cut.frame, labels);
    const std::uint16_t label = cut.stroke.size() < 2 ? std::uint16_t{0} : label_under(cut, labels, width_);
    if (label == 0) return usage_error("the stroke crosses no segment: there is no surface under it");
    if (seen_.back().segment.label == last_label)
        return usage_error("the clip has 65535 segments; there are no more labels");
    const auto part = static_cast<std::uint16_t>(seen_.back().segment.label + 1);
    CutFollower follower(label, part, width_, height_);
    if (!follower.begin(cut, labels))
        return usage_error("the stroke does not part segment " + std::to_string(label) +
                           "; draw it across, from border to border, or round what is to be its own");
    SegmentStore made = *this;
    made.frames_[static_cast<std::size_t>(cut.frame)] = runs_of(labels);
    for (const std::int64_t step : {1, -1}) TRY(made.follow(follower, cut.frame, step, label));
    const FirstLook whole = *find(label);
    made.look_again(label, whole);
    made.look_again(part, whole);
    made.bytes_ = 0;
    for (const Runs& runs : made.frames_) made.bytes_ += runs->size() * sizeof(Run);
    return made;
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
                                 : input_error(ahead.clip().name() + ": has no frames");
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
