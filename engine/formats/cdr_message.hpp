#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "engine/formats/ros_messages.hpp"

namespace touchable {

/// A message of ROS 2, which is CDR, as ROS 1 serialises it: sensor_msgs' Image, CompressedImage and
/// CameraInfo, which are the same fields in the same order but for the sequence number of a header (0 then).
/// Ends where the bytes do, and is empty where they are of another type or no plain CDR, low byte first.
std::string ros1_of_cdr(std::string_view cdr, const RosType& type);
/// The one of these types that a recording of ROS 2 calls so ("sensor_msgs/msg/Image"), or as ROS 1 does.
std::optional<RosType> ros2_type(std::string name);
/// Bytes of CDR that make the first `ros_stamp_bytes` of it.
inline constexpr std::size_t cdr_stamp_bytes = 12;

}  // namespace touchable
