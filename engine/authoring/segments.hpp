#pragma once

// Segments of a whole clip: kept, cut, named, searched.
//
// A SegmentStore has the labels of all frames, compressed. A SegmentCut parts a segment in two along a
// stroke, in all frames. The palette has materials by name and what they feel like; SegmentNames is what a
// person says of segments (a file of JSON, docs/content.md), and the search finds which segments that means.
//
// A store does not change once all frames are added, and may be read by any thread; the rest are plain
// values.

/// Places and strokes in files of ours: names of segments, and a brush's history.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/authoring/segmentation.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Gives pixels without a label (0) that of the nearest one that has any, by a distance transform.
class NearestLabel {
public:
    /// `labels`: width x height, row by row. Where none has a label all stay as they are.
    void fill(std::vector<std::uint16_t>& labels, int width, int height);

private:
    std::vector<std::int32_t> distances_;  // to the label, a third of a pixel
};

/// What a surface of some material is like under a finger.
struct Feel {
    HapticProperties properties{};
    int relief = 100;  ///< per cent of the heights that a clip has there
    bool operator==(const Feel& other) const {
        return properties.stiffness == other.properties.stiffness &&
               properties.static_friction == other.properties.static_friction &&
               properties.dynamic_friction == other.properties.dynamic_friction && relief == other.relief;
    }
};

/// Harder than any device: its own limit counts, which the force guard keeps to. That of the stiffest
/// generated scenes, N/mm.
inline constexpr double as_stiff_as_the_device = 2;

/// A material by its name. Dynamic friction is never above static friction.
struct PaletteMaterial {
    std::string_view name;
    double stiffness;  ///< N/mm
    double static_friction, dynamic_friction;
    int relief;  ///< per cent, estimated
    /// Where the numbers are from, or that they are estimates.
    std::string_view stiffness_source, friction_source;

    Feel feel() const { return {{stiffness * 1000, static_friction, dynamic_friction}, relief}; }
};

std::span<const PaletteMaterial> palette();

/// Null: there is none of that name.
const PaletteMaterial* find_material(std::string_view name);

/// All of them, between commas.
std::string material_names();

/// Why a name is none of the palette's: what was probably meant, and all there are.
std::string no_such_material(std::string_view name);

/// A line drawn over a frame, pixel by pixel of the depth plane: where it crosses a segment, the segment is
/// two from then on, in all frames. One that comes back to where it began parts what is inside of it.
struct SegmentCut {
    struct Point {
        int x = 0, y = 0;
        bool operator==(const Point&) const = default;
    };
    std::int64_t frame = 0;
    std::vector<Point> stroke{};  ///< 2 and more
    bool operator==(const SegmentCut&) const = default;
};

/// The label on which most of the stroke lies, of a picture of labels with that width; 0: none. The stroke
/// lies in the picture.
std::uint16_t label_under(const SegmentCut& cut, const std::vector<std::uint16_t>& labels, int width);

/// Parts one segment along a stroke, and follows both parts from frame to frame.
class CutFollower {
public:
    /// Of a picture of width x height labels; `part` is the label of the smaller part.
    CutFollower(std::uint16_t label, std::uint16_t part, int width, int height);

    /// The frame in which it was drawn. False: the stroke does not part the segment, and nothing was changed.
    bool begin(const SegmentCut& cut, std::vector<std::uint16_t>& labels);
    /// A frame beside the last one that was given, either way through time. Each pixel of the segment belongs
    /// to the part that it belonged to when it was last seen, once the segment is moved as it moved since
    /// then; one that was never seen, to the nearest part. A frame without the segment stays as it is.
    void next(std::vector<std::uint16_t>& labels);

private:
    struct Box {
        int left, top, right, bottom;  // right and bottom beyond the last pixel
        void hold(const Box& other);
    };
    struct Place {
        std::int64_t x = 0, y = 0;
    };
    /// Where the segment is, and the middle of its pixels; nothing: nowhere.
    struct Seen {
        Box box;
        Place middle;
    };
    std::optional<Seen> find(const std::vector<std::uint16_t>& labels) const;
    std::int64_t overlap(const std::vector<std::uint16_t>& labels, const Box& box, const Place& shift) const;
    void shift_known(const Place& shift);
    void remember(const std::vector<std::uint16_t>& labels, const Seen& seen);

    const std::uint16_t label_, part_;
    const int width_, height_;
    std::vector<std::uint16_t> known_;  // which part a place belongs to, since it was seen; 0: nobody knows
    Box known_box_;                     // outside of it nothing is known
    Place middle_;                      // of the segment in the last frame that had it
    std::vector<std::uint16_t> near_;   // of a box
    NearestLabel nearest_;
};

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

/// A pixel of one of a clip's frames.
struct PixelOfFrame {
    int x = 0, y = 0;
    std::int64_t frame = 0;
    bool operator==(const PixelOfFrame&) const = default;
};

/// What a person says of a segment.
struct NamedSegment {
    std::string name;
    std::string material;  ///< of the palette; empty: only its values are known
    Feel feel{};
    std::vector<PixelOfFrame> at{};  ///< a pixel of it, and of each that is joined to it; none: a map says it
    std::optional<int> index{};      ///< of its pixels in that map, 0 to 255
    /// Who says so, for messages: "--at 10,20", "table.json: segments[2]".
    std::string said_by{};
    ErrorKind kind = ErrorKind::usage;  ///< of an error in what is said
    bool is_guess = false;  ///< its material was guessed before; whatever a person says counts instead
};

/// What is known of a clip's segments. As JSON:
/// {"touchable_segments": 1, "otherwise": "wood",
///  "segments": [{"name": "table", "material": "wood", "at": [120, 80, 0]}]}
/// In place of a material, or to change it: stiffness (N/mm), static_friction, dynamic_friction, relief. `at`
/// may be a list of several: segments that are one thing. In place of `at`: index. "by": "guess" says that
/// nobody chose it. "cuts": [{"frame": 0, "stroke": [[10, 20], [30, 20]]}] part segments, one after the
/// other, before anything is named.
struct SegmentNames {
    std::vector<NamedSegment> segments{};
    std::vector<SegmentCut> cuts{};
    std::string otherwise{};  ///< material of all others; empty: a guess for each
    std::string said_by{};    ///< where the cuts are from, for messages
};

inline constexpr std::size_t most_cuts = 1000;
/// Of a text of theirs, in bytes.
inline constexpr std::size_t largest_segment_names = std::size_t{16} << 20;

/// Refused (ErrorKind::input, beginning with `where`) where that cannot be.
Result<SegmentNames> parse_segment_names(std::string_view json, std::string_view where);
/// As text; parse_segment_names gives the same back.
std::string segment_names_to_json(const SegmentNames& names);

}  // namespace touchable

namespace touchable::segment_json {

inline constexpr std::int64_t last_frame = 999'999'999;

/// [X, Y] or [X, Y, FRAME]. Throws checked_json::Refusal, as read_cut does.
PixelOfFrame read_place(const checked_json::Node& node);
nlohmann::ordered_json write_place(const PixelOfFrame& place);

/// {"frame": 0, "stroke": [[X, Y], [X, Y]]}
SegmentCut read_cut(const checked_json::Node& node);
nlohmann::ordered_json write_cut(const SegmentCut& cut);

}  // namespace touchable::segment_json

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
