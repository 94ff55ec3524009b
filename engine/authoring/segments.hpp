// SPDX-License-Identifier: Apache-2.0
#pragma once

// Segments of a whole clip: found, kept, cut, named, searched.
//
// A Segmentation has the surfaces of a frame, each with a label that is the same through the clip;
// begin_segments finds them, frame by frame. A SegmentStore has the labels of all frames, compressed. A
// SegmentCut parts a segment in two along a stroke, in all frames. The palette has materials by name with
// their touch; SegmentNames holds a person's names of segments (a file of JSON, docs/content.md), and
// find_named_segments finds the labels that they mean.
//
// Threads: any may read a store, which does not change once all frames are added; one uses the function from
// begin_segments; the rest are plain values.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A segment as its pixels show it in this frame.
struct Segment {
    std::uint16_t label;  ///< 1 and up, the same through the whole clip; never used again for something else
    std::int32_t pixels;
    std::array<std::uint8_t, 3> colour;  ///< mean, RGB; 0 if the clip has none
    std::int32_t x, y;                   ///< a pixel of it, near its middle and inside of it
    std::int32_t contrast;  ///< mean absolute deviation of brightness from its blur, 1/16 levels: how
                            ///< textured it is; 0 without colour
    bool operator==(const Segment&) const = default;
};

struct Segmentation {
    int width = 0, height = 0;
    std::vector<std::uint16_t> labels;  ///< row by row; 0: no surface (a hole), no segment
    std::vector<Segment> segments;      ///< by label, ascending; only those in this frame
};

/// The pixel of colour nearest to a pixel of depth, if colour has another size.
inline const std::uint8_t* colour_at(const PlaneView& colour, int x, int y, int width, int height) {
    if (colour.width != width) x = (2 * x + 1) * colour.width / (2 * width);
    if (colour.height != height) y = (2 * y + 1) * colour.height / (2 * height);
    return colour.row(y) + std::ptrdiff_t{3} * x;
}

class CutFollower;

/// The touch of a surface.
struct Feel {
    HapticProperties properties{};
    int relief = 100;  ///< per cent of the heights that a clip has there
    bool operator==(const Feel&) const = default;
};

/// N/mm, of materials harder than any device: the device's own limit applies, which the force guard keeps to.
/// That of the stiffest generated scenes.
inline constexpr double as_stiff_as_the_device = 2;

/// A material by its name. Dynamic friction is never above static friction.
struct PaletteMaterial {
    std::string_view name;
    double stiffness;  ///< N/mm
    double static_friction, dynamic_friction;
    int relief;  ///< per cent, estimated
    /// Sources of the numbers, or that they are estimates.
    std::string_view stiffness_source, friction_source;

    Feel feel() const { return {{stiffness * 1000, static_friction, dynamic_friction}, relief}; }
};

std::span<const PaletteMaterial> palette();

/// Null: no material has that name.
const PaletteMaterial* find_material(std::string_view name);

/// Says that a name is not in the palette, with the likely one, and all names.
std::string no_such_material(std::string_view name);

/// A line drawn over a frame, pixel by pixel of the depth plane: it cuts the segment that it crosses in two,
/// in all frames. A closed line cuts out its inside.
struct SegmentCut {
    struct Point {
        int x = 0, y = 0;
        bool operator==(const Point&) const = default;
    };
    std::int64_t frame = 0;
    std::vector<Point> stroke{};  ///< 2 points or more
    bool operator==(const SegmentCut&) const = default;
};

/// The labels of all frames of a clip, compressed. A value: copies share what they have in common.
class SegmentStore {
public:
    SegmentStore(int width, int height) : width_(width), height_(height) {}

    int width() const { return width_; }
    int height() const { return height_; }
    /// Adds the next frame.
    void add(const Segmentation& frame);
    std::int64_t frames() const { return static_cast<std::int64_t>(frames_.size()); }
    /// Memory that it takes.
    std::size_t bytes() const { return bytes_; }
    /// Hash of all labels (hexadecimal XXH64).
    std::string fingerprint() const;
    /// Labels of an existing frame, row by row.
    void read_labels(std::int64_t frame, std::vector<std::uint16_t>& labels) const;
    /// 0: no surface.
    std::uint16_t label_at(std::int64_t frame, int x, int y) const;
    /// An existing frame: its labels, and its segments as they were seen first.
    Segmentation segmentation(std::int64_t frame) const;

    /// A segment as it was seen first.
    struct FirstLook {
        std::int64_t frame = 0;
        Segment segment{};
    };
    /// First looks by label, ascending.
    const std::vector<FirstLook>& seen() const { return seen_; }
    const FirstLook* find(std::uint16_t label) const;  ///< null: there is none
    /// The last frame with a segment that exists.
    std::int64_t last_frame_of(std::uint16_t label) const;

    /// Returns a store with the segment on which most of the stroke lies cut in two. The larger part keeps
    /// its label; the other one gets a new label, and the colour of the whole. In other frames the border
    /// goes with the segment. Errors (ErrorKind::usage): a stroke that leads out of the picture or the clip,
    /// or that parts no segment. ErrorKind::interrupted if cancelled (stop_requested).
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

/// A pixel of one of a clip's frames.
struct PixelOfFrame {
    int x = 0, y = 0;
    std::int64_t frame = 0;
    bool operator==(const PixelOfFrame&) const = default;
};

/// A person's name and material of a segment.
struct NamedSegment {
    std::string name;
    std::string material;  ///< of the palette; empty: only its values are known
    Feel feel{};
    std::vector<PixelOfFrame> at{};  ///< a pixel of it, and of each segment joined to it; none: see index
    std::optional<int> index{};      ///< value of its pixels in a map, 0 to 255
    /// Its source, for messages: "--at 10,20", "table.json: segments[2]".
    std::string said_by{};
    ErrorKind kind = ErrorKind::usage;  ///< of an error in this entry
    bool is_guess = false;              ///< its material was guessed; a person's choice takes precedence
};

/// Names of a clip's segments. As JSON:
/// {"touchable_segments": 1, "otherwise": "wood",
///  "segments": [{"name": "table", "material": "wood", "at": [120, 80, 0]}]}
/// In place of a material, or to change it: stiffness (N/mm), static_friction, dynamic_friction, relief. `at`
/// may be a list of several: segments that are one thing. In place of `at`: index. "by": "guess" marks a
/// guess. "cuts": [{"frame": 0, "stroke": [[10, 20], [30, 20]]}] part segments, one after the other, before
/// naming.
struct SegmentNames {
    std::vector<NamedSegment> segments{};
    std::vector<SegmentCut> cuts{};
    std::string otherwise{};  ///< material of all others; empty: a guess for each
    std::string said_by{};    ///< source of the cuts, for messages
};

inline constexpr std::size_t most_cuts = 1000;
/// Bytes; largest text of SegmentNames.
inline constexpr std::size_t largest_segment_names = std::size_t{16} << 20;

/// An error (ErrorKind::input, beginning with `where`) for an invalid text.
Result<SegmentNames> parse_segment_names(std::string_view json, std::string_view where);
/// The names as text; parse_segment_names returns the same.
std::string segment_names_to_json(const SegmentNames& names);

/// Returns segments of a clip's frames in order, each valid until the next call; `follows`: the frame before.
using SegmentFrames = std::function<const Segmentation&(const RawFrame& frame, bool follows)>;
/// Begins a clip of that scene.
using BeginSegments = std::function<SegmentFrames(const Scene& scene)>;

/// Finds segments by colour and depth (segmentation.hpp).
SegmentFrames begin_segments(const Scene& scene);

/// A picture that numbers the segments of a clip's first frame: `index` of NamedSegment, a byte each.
struct SegmentMap {
    std::string file;
    Image indices;
};

/// Named segments by their label.
using LabelNames = std::map<std::uint16_t, NamedSegment>;

/// Finds the labels that the names mean; cuts are ignored. In a map, a segment has the index of most of its
/// pixels; a name of one of its pixels takes precedence. Each name that is found has a pixel of its own
/// (`at`). Errors: a pixel beyond the picture or without a segment, a frame beyond the clip, one segment
/// under two names that feel different, an index without a map.
Result<LabelNames> find_named_segments(Prefetch& ahead, const SegmentNames& names,
                                       const std::optional<SegmentMap>& map, const BeginSegments& begin);

/// The same for a store, which must have at least one frame.
Result<LabelNames> find_named_segments(const SegmentStore& segments, const SegmentNames& names,
                                       const std::optional<SegmentMap>& map);

/// Returns the segments with all cuts of the names, one after the other. Errors as of SegmentStore::with_cut,
/// with the number of the cut (ErrorKind::input).
Result<SegmentStore> with_cuts(SegmentStore segments, const SegmentNames& names);

}  // namespace touchable
