#pragma once

// Materials of a recording's segments: haptic pictures for a recording that has none.
//
// with_materials gives a clip whose segments feel as they are named, or else as a guess by colour and place
// says. A MaterialBrush has the segments as a person paints them: the states that there were (each immutable:
// names, and the segments as painted), an undo that goes back among them, and its history as a file's text,
// which another run of the program repeats. with_painted_segments gives the clip in which they feel so.
//
// A reader is one thread's. Changes of a brush take long and are one thread's; PaintedSegments, once made,
// may be read by any thread. A stop is heard between frames.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string_view>

#include "engine/authoring/segments.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What all segments of a clip are like: of one moment, never changed.
struct PaintedSegments {
    /// What a segment is like, and who says so.
    struct Paint {
        std::string name{};      ///< empty: it was given none
        std::string material{};  ///< of the palette; empty: values of its own
        Feel feel{};
        bool is_guess = false;
    };
    std::shared_ptr<const SegmentStore> segments;
    std::map<std::uint16_t, Paint> by_label{};  ///< of all that are seen anywhere
};

/// The clip with haptic pictures in place of its own, in which each segment feels as painted: those that
/// with_materials makes of the same names. Any frame at once. Refused (ErrorKind::usage) where the clip has
/// not the segments' size, and for a live source.
Result<std::unique_ptr<ClipReader>> with_painted_segments(std::unique_ptr<ClipReader> clip,
                                                          std::shared_ptr<const PaintedSegments> painted);

struct MaterialSettings {
    SegmentNames names{};
    std::optional<SegmentMap> map{};
    /// Heights (8 bits, 128 is level, as with_relief makes them) are scaled by each material's relief.
    bool scale_relief = false;
    /// That the haptic pictures have; values beyond are cut. Nothing: some that hold all (ranges_of_palette).
    std::optional<HapticRanges> ranges{};
};

/// What was found in the frames read since the clip's beginning.
struct MaterialReport {
    /// A segment as it was seen first.
    struct Seen {
        std::uint16_t label = 0;
        PixelOfFrame at{};  ///< a pixel of it
        std::int32_t pixels = 0;
        std::array<std::uint8_t, 3> colour{};
        PaintedSegments::Paint paint{};
    };
    std::vector<Seen> segments;  ///< in the order in which they came
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

/// Materials of a clip's segments as a person paints them, with undo. What was not painted feels as its
/// first look suggests, or as all others do. As a file (history):
/// {"touchable_brush": 1, "segments": "<hash of all labels>", "done": 1, "begin": {names of segments},
///  "edits": [{"paint": [10, 20, 0], "material": "wood"}, {"join": [[1, 2, 0], [3, 4, 0]]},
///            {"cut": {"frame": 0, "stroke": [[1, 2], [3, 4]]}}, {"otherwise": "felt"}]}
class MaterialBrush {
public:
    /// One thing that is done with a brush.
    struct Paint {
        PixelOfFrame at;
        std::string material;
    };
    /// Both segments are one thing: of the material of the one that was painted, otherwise of the first.
    struct Join {
        PixelOfFrame a, b;
    };
    struct Otherwise {
        std::string material;  ///< of all that have no name; empty: guesses
    };
    using Edit = std::variant<Paint, Join, SegmentCut, Otherwise>;

    /// As many are kept for undo; less where segments that are cut take more than 1 GiB.
    static constexpr std::size_t most_edits = 200;

    /// With what was said of the segments before, such as in a file; `segments` are without its cuts, and of
    /// at least one frame. Refused as find_named_segments and with_cuts do.
    static Result<MaterialBrush> begin(SegmentStore segments, const SegmentNames& names = {});

    /// What was done, in words: "segment 7 is wood". Refused (ErrorKind::usage), and then nothing is changed:
    /// a place beyond the clip or without a surface, no such material, a stroke that parts nothing, more cuts
    /// than a file of names has. ErrorKind::interrupted where it is given up (stop_requested).
    Result<std::string> edit(const Edit& edit);
    /// What was undone, or done again, in words. Refused where there is nothing.
    Result<std::string> undo();
    Result<std::string> redo();
    /// How many edits count now, and how many there are with those that were undone.
    std::size_t done() const { return done_; }
    std::size_t edits() const { return edits_.size(); }

    /// As all is now; what it points to stays as it is.
    std::shared_ptr<const PaintedSegments> painted() const { return states_[done_].painted; }
    /// For a file that --segments reads.
    const SegmentNames& names() const { return states_[done_].names; }

    /// All that was done and undone, for another run of the program.
    std::string history() const;
    /// Brings a history back in place of all that is here. Refused (ErrorKind::input, beginning with
    /// `where`), and then nothing is changed, where it is none, or of other segments. ErrorKind::interrupted
    /// where it is given up.
    Result<void> repeat(std::string_view history, const std::string& where);

private:
    struct State {
        SegmentNames names;
        std::shared_ptr<const PaintedSegments> painted;
    };
    struct Done {
        Edit edit;
        std::string words;
    };
    MaterialBrush() = default;
    static Result<State> state_of(std::shared_ptr<const SegmentStore> segments, SegmentNames names);
    class Draft;
    void forget_oldest();

    std::shared_ptr<const SegmentStore> uncut_;
    std::vector<State> states_;  // before the first edit, after it, ...: one more than edits
    std::vector<Done> edits_;
    std::size_t done_ = 0;
};

}  // namespace touchable
