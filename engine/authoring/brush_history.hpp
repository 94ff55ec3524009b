#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/authoring/segment_names.hpp"
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

}  // namespace touchable
