#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/authoring/brush_history.hpp"
#include "engine/authoring/painted_clip.hpp"
#include "engine/authoring/segment_names.hpp"
#include "engine/authoring/segment_store.hpp"
#include "engine/base/result.hpp"

namespace touchable {

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
