#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/clip/clip.hpp"

namespace touchable::test {

/// A message of ROS 2, in CDR.
struct Ros2Message {
    std::string topic, type;  ///< "sensor_msgs/msg/Image"
    std::int64_t time_ns;     ///< when it was recorded
    std::string bytes;
};

/// Depth of 16x12, its camera, colour, and what is no picture: three of each, in the order of time.
std::vector<Ros2Message> ros2_recording();

/// Expects a clip of the last `frames` of these: codes, times, colour, and every point
/// where an unprojection written here has it.
void expect_ros2_recording(ClipReader& clip, int frames = 3);

}  // namespace touchable::test
