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

/// A type of messages that is read, in the one form that it has had: its name, and the hash of its
/// definition.
struct RosType {
    std::string_view name, md5;
    bool operator==(const RosType&) const = default;
};
inline constexpr RosType ros_image{"sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743"},
    ros_compressed_image{"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f"},
    ros_camera_info{"sensor_msgs/CameraInfo", "c9a58c1b0b154e0e6da7578cb991d214"},
    ros_transform{"geometry_msgs/Transform", "ac9eff44abf714214112b05d54a3cf9b"},
    ros_float{"std_msgs/Float32", "73fcbf46b49191e672908e50842a83d4"};

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
