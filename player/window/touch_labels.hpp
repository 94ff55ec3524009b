#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// What a place of a clip is called.
struct TouchLabel {
    std::map<std::string, std::string> captions;          ///< by language; "" is any
    std::map<std::string, std::filesystem::path> sounds;  ///< likewise; perhaps none
    std::vector<glm::dvec2> corners;  ///< of a polygon, pixels of the clip's depth; or none:
    std::string segment;              ///< the name of a segment
    std::int64_t first = 0, last = std::numeric_limits<std::int64_t>::max();  ///< frames
};
/// What of it is in that language; otherwise in English, in any, or in the first there is. Null: there is
/// none.
template <class Said>
const Said* said_in(const std::map<std::string, Said>& by_language, const std::string& language) {
    for (const std::string& tried : {language, std::string("en"), std::string()})
        if (const auto found = by_language.find(tried); found != by_language.end()) return &found->second;
    return by_language.empty() ? nullptr : &by_language.begin()->second;
}

/// The labels of a clip. As JSON:
/// {"touchable_labels": 1, "labels": [
///  {"caption": {"en": "Africa", "de": "Afrika"}, "sound": {"en": "africa.wav", "de": "afrika.wav"},
///   "rectangle": [300, 120, 420, 260], "frames": [0, 119]},
///  {"caption": "Etna", "polygon": [[10, 10], [40, 12], [25, 30]]},
///  {"caption": "a bell", "segment": "bell"}]}
/// A rectangle is its left, top, right and bottom pixel. Frames are the first and the last; left out: all.
/// The name of a segment is that of a file of segments (segment_names.hpp). Of labels that lie over each
/// other the first counts.
struct TouchLabels {
    std::vector<TouchLabel> labels;
    std::string said_by;  ///< for messages

    /// Which one a place of the surface has, `segment`: the name of the segment there.
    std::optional<std::size_t> at(const glm::dvec2& pixel, std::int64_t frame,
                                  std::string_view segment) const;
    /// Refused (ErrorKind::input) where one is beyond a clip of that many pixels and frames; 0: nobody knows.
    Result<void> fits(int width, int height, std::int64_t frames) const;
    /// Likewise where one is of a segment that has none of these names.
    Result<void> has_segments(const std::vector<std::string>& names) const;
};

inline constexpr std::size_t most_labels = 1000;
/// A longer file is refused, bytes.
inline constexpr std::size_t largest_labels = std::size_t{1} << 20;

/// `folder`: where the names of sounds begin. Refused (ErrorKind::input, beginning with `where`) where that
/// cannot be.
Result<TouchLabels> parse_touch_labels(std::string_view json, std::string_view where,
                                       const std::filesystem::path& folder);

}  // namespace touchable
