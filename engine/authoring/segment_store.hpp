#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/authoring/segment_cut.hpp"
#include "engine/authoring/segmentation.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// The labels of all frames of a clip, kept in little memory. A value: copies share what they have in common.
class SegmentStore {
public:
    SegmentStore(int width, int height) : width_(width), height_(height) {}

    int width() const { return width_; }
    int height() const { return height_; }
    /// The next frame's.
    void add(const Segmentation& frame);
    std::int64_t frames() const { return static_cast<std::int64_t>(frames_.size()); }
    /// That it takes.
    std::size_t bytes() const { return bytes_; }
    /// Of all labels: another one where any is another (hexadecimal XXH64).
    std::string fingerprint() const;
    /// Of a frame that there is, row by row.
    void read_labels(std::int64_t frame, std::vector<std::uint16_t>& labels) const;
    /// 0: no surface.
    std::uint16_t label_at(std::int64_t frame, int x, int y) const;
    /// Of a frame that there is: its labels, and its segments as they were seen first.
    Segmentation segmentation(std::int64_t frame) const;

    /// A segment as it was seen first.
    struct FirstLook {
        std::int64_t frame = 0;
        Segment segment{};
    };
    /// By label, ascending.
    const std::vector<FirstLook>& seen() const { return seen_; }
    const FirstLook* find(std::uint16_t label) const;  ///< null: there is none
    /// The last frame that has a segment that there is.
    std::int64_t last_frame_of(std::uint16_t label) const;

    /// The same with the segment on which most of the stroke lies cut in two. The larger part keeps its
    /// label; the other one has a label of its own, and the colour of the whole. In other frames the border
    /// goes with the segment. Refused (ErrorKind::usage): a stroke that leads out of the picture or the clip,
    /// or that parts no segment. ErrorKind::interrupted where it is given up (stop_requested).
    Result<SegmentStore> with_cut(const SegmentCut& cut) const;

private:
    struct Run {
        std::uint16_t label, pixels;
    };
    using Runs = std::shared_ptr<const std::vector<Run>>;
    static Runs runs_of(const std::vector<std::uint16_t>& labels);
    bool has(std::int64_t frame, std::uint16_t label) const;
    Result<void> follow(CutFollower follower, std::int64_t from, std::int64_t step, std::uint16_t label);
    void look_again(std::uint16_t label, const FirstLook& whole);

    int width_, height_;
    std::vector<Runs> frames_;
    std::size_t bytes_ = 0;
    std::vector<FirstLook> seen_;
};

}  // namespace touchable
