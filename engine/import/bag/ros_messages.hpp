#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace touchable {

/// Messages of ROS 1 as it serialises them. Texts and data are parts of the bytes given. Each is nothing
/// where the bytes are too few for it.

struct RosHeader {
    std::int64_t stamp_ns = 0;
    std::string_view frame;
};
/// Of messages that begin with a header: enough of their bytes for its stamp.
inline constexpr std::size_t ros_stamp_bytes = 12;
std::optional<std::int64_t> ros_stamp(std::string_view begin);

/// sensor_msgs/Image
struct RosImage {
    RosHeader header;
    std::uint32_t height = 0, width = 0;
    std::string_view encoding;
    bool is_big_endian = false;
    std::uint32_t step = 0;  ///< bytes from one row to the next
    std::string_view data;
};
std::optional<RosImage> parse_ros_image(std::string_view message);

/// sensor_msgs/CompressedImage
struct RosCompressedImage {
    RosHeader header;
    std::string_view format, data;
};
std::optional<RosCompressedImage> parse_ros_compressed_image(std::string_view message);

/// sensor_msgs/CameraInfo
struct RosCameraInfo {
    RosHeader header;
    std::uint32_t height = 0, width = 0;
    std::string_view distortion_model;
    std::vector<double> distortion;
    std::array<double, 9> matrix{};       ///< K: of the picture as it was taken
    std::array<double, 12> projection{};  ///< P: of the picture once it is rectified
    struct {
        std::uint32_t x = 0, y = 0, height = 0, width = 0;  ///< 0: all
    } region;
};
std::optional<RosCameraInfo> parse_ros_camera_info(std::string_view message);

/// std_msgs/Float32
std::optional<float> parse_ros_float(std::string_view message);

/// geometry_msgs/Transform: a rotation, and then a translation.
struct RosTransform {
    std::array<double, 3> translation{};
    std::array<double, 4> rotation{};  ///< quaternion x, y, z, w
};
std::optional<RosTransform> parse_ros_transform(std::string_view message);

}  // namespace touchable
