#include "engine/authoring/segment_store.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "engine/base/byte_hash.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::size_t longest_run = 65535, last_label = 65535;

bool is_before_label(const SegmentStore::FirstLook& look, std::uint16_t label) {
    return look.segment.label < label;
}

/// Of one label, a pixel amid its longest run of a row, and how many pixels there are.
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
    for (const Segment& segment : frame.segments) {
        const auto at = std::lower_bound(seen_.begin(), seen_.end(), segment.label, is_before_label);
        if (at != seen_.end() && at->segment.label == segment.label) continue;
        seen_.insert(at, {frames(), segment});
    }
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
    auto left = static_cast<std::int64_t>(y) * width_ + x;  // pixels before it that are still to be passed
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
    const auto at = std::lower_bound(seen_.begin(), seen_.end(), label, is_before_label);
    return at == seen_.end() || at->segment.label != label ? nullptr : &*at;
}

std::int64_t SegmentStore::last_frame_of(std::uint16_t label) const {
    std::int64_t frame = frames() - 1;
    while (frame > 0 && !has(frame, label)) --frame;
    return frame;
}

bool SegmentStore::has(std::int64_t frame, std::uint16_t label) const {
    const auto& runs = *frames_[static_cast<std::size_t>(frame)];
    return std::any_of(runs.begin(), runs.end(), [&](const Run& run) { return run.label == label; });
}

/// Through the frames beyond `from`, either way.
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

/// Where a part of a segment is seen first, since the other one may have what was named there.
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
    const auto at = std::lower_bound(seen_.begin(), seen_.end(), label, is_before_label);
    if (at != seen_.end() && at->segment.label == label)
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
                               ',' + std::to_string(point.y) + ", which has " + std::to_string(width_) + 'x' +
                               std::to_string(height_));
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

}  // namespace touchable
