// SPDX-License-Identifier: Apache-2.0
#pragma once

// Materials of a recording's segments: haptic pictures for a recording that has none.
//
// with_materials returns a clip whose segments feel as named, otherwise as guessed by colour and place. A
// MaterialBrush holds the segments as a person paints them: all states (each immutable: names, and the
// segments as painted), an undo among them, and its history as a file's text, which another run of the
// program repeats. with_painted_segments returns the clip with painted segments.
//
// Threads: one uses a reader, one edits a brush, which takes long; any may read PaintedSegments, once made.
// Stop requests are checked between frames.

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

/// The touch of all segments of a clip at one moment; immutable.
struct PaintedSegments {
    /// The touch of a segment, and where it comes from.
    struct Paint {
        std::string name{};      ///< empty: unnamed
        std::string material{};  ///< of the palette; empty: values of its own
        Feel feel{};
        bool is_guess = false;
    };
    std::shared_ptr<const SegmentStore> segments;
    std::map<std::uint16_t, Paint> by_label{};  ///< all segments that occur
};

/// Returns the clip with its haptic pictures replaced by those of painted segments, the same that
/// with_materials makes of the same names. Any frame at once. An error (ErrorKind::usage) for a clip that has
/// not the segments' size, and for a live source.
Result<std::unique_ptr<ClipReader>> with_painted_segments(std::unique_ptr<ClipReader> clip,
                                                          std::shared_ptr<const PaintedSegments> painted);

struct MaterialSettings {
    SegmentNames names{};
    std::optional<SegmentMap> map{};
    /// Heights (8 bits, 128 is level, as with_relief makes them) are scaled by each material's relief.
    bool scale_relief = false;
    /// Ranges to paint with; values beyond are clamped. nullopt: ranges that hold all (ranges_of_palette).
    std::optional<HapticRanges> ranges{};
};

/// Findings in the frames read since the clip's beginning.
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
    /// Pixels with a segment in two consecutive frames, and those of them whose segment changed.
    std::int64_t compared = 0, changed = 0;
    double seconds = 0;  ///< time for segments and haptic pictures
};

/// Reads the segments of all frames of a clip, from its beginning to its end. `progress`, if any, is called
/// before each frame with its number. Errors: a frame that cannot be read; no frames; more segments than fit
/// into 1 GiB.
Result<SegmentStore> read_segments(ClipReader& clip, const BeginSegments& begin,
                                   const std::function<void(std::int64_t frame)>& progress);

/// Returns the clip with its haptic pictures replaced by those of its segments' materials: as named,
/// otherwise as guessed from a segment's first look. A segment keeps its material. The report is filled as
/// frames are read. Seeking reads all frames from the first on, since segments are followed; if segments are
/// cut, all frames are read once before. Errors as of find_named_segments and with_cuts; also for a frame
/// that lacks the colour for a guess, or heights that can be scaled.
Result<std::unique_ptr<ClipReader>> with_materials(std::unique_ptr<ClipReader> clip,
                                                   const MaterialSettings& settings,
                                                   const BeginSegments& begin,
                                                   std::shared_ptr<MaterialReport> report);

/// Materials of a clip's segments as a person paints them, with undo. Segments that are not painted feel as
/// guessed from their first look, or as `Otherwise` says. As a file (history):
/// {"touchable_brush": 1, "segments": "<hash of all labels>", "done": 1, "begin": {names of segments},
///  "edits": [{"paint": [10, 20, 0], "material": "wood"}, {"join": [[1, 2, 0], [3, 4, 0]]},
///            {"cut": {"frame": 0, "stroke": [[1, 2], [3, 4]]}}, {"otherwise": "felt"}]}
class MaterialBrush {
public:
    /// An edit: gives the segment at a pixel a material.
    struct Paint {
        PixelOfFrame at;
        std::string material;
    };
    /// An edit: makes both segments one, of the material of the painted one, otherwise of the first.
    struct Join {
        PixelOfFrame a, b;
    };
    struct Otherwise {
        std::string material;  ///< of all unnamed segments; empty: guesses
    };
    using Edit = std::variant<Paint, Join, SegmentCut, Otherwise>;

    /// Number of edits kept for undo; fewer if segments that are cut take more than 1 GiB.
    static constexpr std::size_t most_edits = 200;

    /// Begins with earlier names of the segments, such as a file's; `segments` are without its cuts, and of
    /// at least one frame. Errors as of find_named_segments and with_cuts.
    static Result<MaterialBrush> begin(SegmentStore segments, const SegmentNames& names = {});

    /// Returns what was done, in words: "segment 7 is wood". Errors change nothing (ErrorKind::usage): a
    /// place beyond the clip or without a surface, an unknown material, a stroke that parts nothing, more
    /// cuts than a file of names has. ErrorKind::interrupted if cancelled (stop_requested).
    Result<std::string> edit(const Edit& edit);
    /// Returns what was undone, or done again, in words. An error if there is nothing.
    Result<std::string> undo();
    Result<std::string> redo();
    /// Number of edits in effect, and of all edits with those that were undone.
    std::size_t done() const { return done_; }
    std::size_t edits() const { return edits_.size(); }

    /// The current state, which is immutable.
    std::shared_ptr<const PaintedSegments> painted() const { return states_[done_].painted; }
    /// For a file that --segments reads.
    const SegmentNames& names() const { return states_[done_].names; }

    /// All that was done and undone, for another run of the program.
    std::string history() const;
    /// Replaces all edits by those of a history. Errors change nothing: ErrorKind::input, beginning with
    /// `where`, for a text that is no history, or one of other segments; ErrorKind::interrupted if cancelled.
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
