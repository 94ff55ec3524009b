#pragma once

// Materials by brush: what a person does to the segments of a clip, with undo and redo, kept from one run to
// the next.
//
// A MaterialBrush holds the states that there were (each immutable: names, and the segments as painted) and
// an undo that goes back among them; BrushHistory is the file in which what was done is written, and done
// again the next time.
//
// Changes take long and are one thread's; a state, once made, may be read by any thread.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/authoring/materials.hpp"
#include "engine/authoring/segments.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// One thing that is done with a brush.
struct PaintEdit {
    PixelOfFrame at;
    std::string material;
};
/// Both segments are one thing: of the material of the one that was painted, otherwise of the first.
struct JoinEdit {
    PixelOfFrame a, b;
};
struct OtherwiseEdit {
    std::string material;  ///< of all that nobody named; empty: guesses
};
using BrushEdit = std::variant<PaintEdit, JoinEdit, SegmentCut, OtherwiseEdit>;

/// All that was done with a brush, for another run of the program. As JSON:
/// {"touchable_brush": 1, "segments": "<hash of all labels>", "done": 1, "begin": {names of segments},
///  "edits": [{"paint": [10, 20, 0], "material": "wood"}, {"join": [[1, 2, 0], [3, 4, 0]]},
///            {"cut": {"frame": 0, "stroke": [[1, 2], [3, 4]]}}, {"otherwise": "felt"}]}
struct BrushHistory {
    std::string segments{};  ///< SegmentStore::fingerprint of those that are not cut yet
    SegmentNames begin{};    ///< before the first edit
    std::vector<BrushEdit> edits{};
    std::size_t done = 0;  ///< how many of them count; those behind were undone
};

/// Refused (ErrorKind::input, beginning with `where`) where it is no history.
Result<BrushHistory> parse_brush_history(std::string_view json, const std::string& where);
std::string brush_history_to_json(const BrushHistory& history);

/// Materials of a clip's segments as a person paints them, with undo. What nobody painted feels as its first
/// look suggests, or as all others do.
class MaterialBrush {
public:
    using Paint = PaintEdit;
    using Join = JoinEdit;
    using Otherwise = OtherwiseEdit;
    using Edit = BrushEdit;
    /// As many are kept for undo; less where segments that are cut take more than 1 GiB.
    static constexpr std::size_t most_edits = 200;

    /// With what was said of the segments before, such as in a file; `segments` are without its cuts, and of
    /// at least one frame. Refused as find_named_segments and with_cuts do.
    static Result<MaterialBrush> begin(SegmentStore segments, const SegmentNames& names = {});

    /// What was done, in words: "segment 7 is wood". Refused (ErrorKind::usage), and then nothing is changed:
    /// a place beyond the clip or without a surface, no such material, a stroke that parts nothing, more cuts
    /// than a file of names has. ErrorKind::interrupted where it is given up (stop_requested).
    Result<std::string> edit(const Edit& edit);
    /// Likewise what was done. Refused where there is nothing.
    Result<std::string> undo();
    Result<std::string> redo();
    /// How many edits count now, and how many there are with those that were undone.
    std::size_t done() const { return done_; }
    std::size_t edits() const { return edits_.size(); }

    /// As all is now; what it points to stays as it is.
    std::shared_ptr<const PaintedSegments> painted() const { return states_[done_].painted; }
    /// For a file that --segments reads.
    const SegmentNames& names() const { return states_[done_].names; }

    /// All that was done and undone, for another run of the program (brush_history_to_json).
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
