#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace touchable {

/// YAML as programs write a camera into it, as JSON: maps and lists by indentation or in brackets, numbers
/// and words. Tags, anchors and comments are passed over; of several documents the first is read, of members
/// with one name the first. What has a point in its name, such as Camera.fx of ORB-SLAM, is a member of a
/// member. Null for what is no map, is nested deeper than 16, or is none of this.
nlohmann::json plain_yaml(std::string_view text);

}  // namespace touchable
