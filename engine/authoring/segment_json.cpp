#include "engine/authoring/segment_json.hpp"

#include <cstddef>
#include <utility>

namespace touchable::segment_json {
namespace {

constexpr std::int64_t last_pixel = 16383;
constexpr std::size_t most_points = 10000;

}  // namespace

PixelOfFrame read_place(const checked_json::Node& node) {
    const auto numbers = node.elements(2, 3, "[X, Y] or [X, Y, FRAME]");
    PixelOfFrame place;
    place.x = static_cast<int>(numbers[0].integer(0, last_pixel));
    place.y = static_cast<int>(numbers[1].integer(0, last_pixel));
    if (numbers.size() == 3) place.frame = numbers[2].integer(0, last_frame);
    return place;
}

nlohmann::ordered_json write_place(const PixelOfFrame& place) {
    return {place.x, place.y, place.frame};
}

SegmentCut read_cut(const checked_json::Node& node) {
    node.allow_only({"frame", "stroke"});
    SegmentCut cut;
    cut.frame = node["frame"].integer(0, last_frame);
    for (const checked_json::Node& point :
         node["stroke"].elements(2, most_points, "a list of 2 to 10000 points, [X, Y] each")) {
        const auto numbers = point.elements(2, 2, "[X, Y]");
        cut.stroke.push_back({static_cast<int>(numbers[0].integer(0, last_pixel)),
                              static_cast<int>(numbers[1].integer(0, last_pixel))});
    }
    return cut;
}

nlohmann::ordered_json write_cut(const SegmentCut& cut) {
    nlohmann::ordered_json stroke = nlohmann::ordered_json::array();
    for (const SegmentCut::Point& point : cut.stroke)
        stroke.push_back(nlohmann::ordered_json::array({point.x, point.y}));
    nlohmann::ordered_json json;
    json["frame"] = cut.frame;
    json["stroke"] = std::move(stroke);
    return json;
}

}  // namespace touchable::segment_json
