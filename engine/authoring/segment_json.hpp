#pragma once

#include <nlohmann/json.hpp>

#include "engine/authoring/segment_cut.hpp"
#include "engine/authoring/segment_names.hpp"
#include "engine/scene/checked_json.hpp"

/// Places and strokes in files of ours: names of segments, and a brush's history.
namespace touchable::segment_json {

inline constexpr std::int64_t last_frame = 999'999'999;

/// [X, Y] or [X, Y, FRAME]. Throws checked_json::Refusal, as read_cut does.
PixelOfFrame read_place(const checked_json::Node& node);
nlohmann::ordered_json write_place(const PixelOfFrame& place);

/// {"frame": 0, "stroke": [[X, Y], [X, Y]]}
SegmentCut read_cut(const checked_json::Node& node);
nlohmann::ordered_json write_cut(const SegmentCut& cut);

}  // namespace touchable::segment_json
