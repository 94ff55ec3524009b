#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/authoring/palette.hpp"
#include "engine/authoring/segment_cut.hpp"
#include "engine/base/result.hpp"

namespace touchable {

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
