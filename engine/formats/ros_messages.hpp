// SPDX-License-Identifier: Apache-2.0
#pragma once

// Messages in the serialisations of ROS 1 and of ROS 2 (CDR). Texts and data refer to the message's bytes.
// Parsers return nothing if there are too few bytes, or for another CDR than the plain, little-endian one.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// A message type that is read: its name, and the hash of the only definition that it has had.
struct RosType {
    std::string_view name, md5;
    bool operator==(const RosType&) const = default;
};
inline constexpr RosType ros_image{"sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743"},
    ros_compressed_image{"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f"},
    ros_camera_info{"sensor_msgs/CameraInfo", "c9a58c1b0b154e0e6da7578cb991d214"},
    ros_transform{"geometry_msgs/Transform", "ac9eff44abf714214112b05d54a3cf9b"},
    ros_float{"std_msgs/Float32", "73fcbf46b49191e672908e50842a83d4"};

/// Reads values one after the other, low byte first, and texts behind their lengths; MCAP has the same form.
/// Once the bytes run out, all further values are 0 or empty.
class RosFields {
public:
    explicit RosFields(std::string_view bytes) : left_(bytes) {}
    bool ok() const { return ok_; }
    template <class Number>
    Number number() {
        Number value{};
        const std::string_view bytes = take(sizeof value);
        if (ok_) std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }
    std::string_view text() { return take(number<std::uint32_t>()); }
    std::size_t left() const { return left_.size(); }

protected:
    std::string_view take(std::size_t count) {
        ok_ = ok_ && count <= left_.size();
        if (!ok_) return {};
        const std::string_view taken = left_.substr(0, count);
        left_.remove_prefix(count);
        return taken;
    }

    bool ok_ = true;

private:
    std::string_view left_;
};

struct RosMessage {
    std::string bytes;
    bool is_cdr = false;
};

struct RosHeader {
    std::int64_t stamp_ns = 0;
    std::string_view frame;
};
/// First bytes of a message with a header that include the header's stamp, in either serialisation.
inline constexpr std::size_t ros_stamp_bytes = 12;
std::optional<std::int64_t> ros_stamp(const RosMessage& begin);

/// sensor_msgs/Image
struct RosImage {
    RosHeader header;
    std::uint32_t height = 0, width = 0;
    std::string_view encoding;
    bool is_big_endian = false;
    std::uint32_t step = 0;  ///< bytes from one row to the next
    std::string_view data;
};
std::optional<RosImage> parse_ros_image(const RosMessage& message);

/// sensor_msgs/CompressedImage
struct RosCompressedImage {
    RosHeader header;
    std::string_view format, data;
};
std::optional<RosCompressedImage> parse_ros_compressed_image(const RosMessage& message);

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
std::optional<RosCameraInfo> parse_ros_camera_info(const RosMessage& message);

/// std_msgs/Float32
std::optional<float> parse_ros_float(const RosMessage& message);

/// geometry_msgs/Transform: a rotation, and then a translation.
struct RosTransform {
    std::array<double, 3> translation{};
    std::array<double, 4> rotation{};  ///< quaternion x, y, z, w
};
std::optional<RosTransform> parse_ros_transform(const RosMessage& message);

/// The type that ROS 2 ("sensor_msgs/msg/Image") or ROS 1 calls `name`, if both serialise it alike.
std::optional<RosType> ros2_type(std::string name);
/// What a picture message holds, by its encoding.
enum class RosPictureKind { none, grey8, depth16, depth_floats, colour };
RosPictureKind ros_picture_kind(std::string_view encoding);
/// The same for compressed pictures, by their format ("16UC1; compressedDepth", "rgb8; jpeg compressed bgr8",
/// "png"). If the format does not tell depth from colour, the topic's name has to.
RosPictureKind ros_compressed_kind(std::string_view format);

/// Decodes to grey of 8 or 16 bits, floats, or RGB of 8 bits, in host order, without padding. Messages begin
/// with `where`.
Result<StoredImage> ros_picture(const RosImage& image, const std::string& where);
/// Decodes PNG, JPEG, and depth that `compressed_depth_image_transport` packed as PNG or RVL (floats in
/// metres).
Result<StoredImage> ros_picture(const RosCompressedImage& image, const std::string& where);

/// Unpacks `pixels` depths from RVL (Wilson, Fast lossless depth image compression, 2017); nothing if the
/// words end before, or a run is longer than the pixels left.
std::optional<std::vector<std::uint16_t>> unpack_rvl(std::string_view words, std::size_t pixels);

}  // namespace touchable
