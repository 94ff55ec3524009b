#pragma once

// Messages as ROS 1 serialises them, and what ROS 2 has of them, brought into that form. Texts and data are
// parts of the bytes given. A message is nothing where the bytes are too few for it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

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

/// Values one after the other, low byte first, and texts behind their lengths, as also MCAP has them. Once
/// the bytes are too few, all that follows is 0.
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

private:
    std::string_view take(std::size_t count) {
        ok_ = ok_ && count <= left_.size();
        if (!ok_) return {};
        const std::string_view taken = left_.substr(0, count);
        left_.remove_prefix(count);
        return taken;
    }

    std::string_view left_;
    bool ok_ = true;
};

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

/// A message of ROS 2, which is CDR, as ROS 1 serialises it: sensor_msgs' Image, CompressedImage and
/// CameraInfo, which are the same fields in the same order but for the sequence number of a header (0 then).
/// Ends where the bytes do, and is empty where they are of another type or no plain CDR, low byte first.
std::string ros1_of_cdr(std::string_view cdr, const RosType& type);
/// The one of these types that a recording of ROS 2 calls so ("sensor_msgs/msg/Image"), or as ROS 1 does.
std::optional<RosType> ros2_type(std::string name);
/// Bytes of CDR that make the first `ros_stamp_bytes` of it.
inline constexpr std::size_t cdr_stamp_bytes = 12;

/// What a message of pictures holds, as its encoding says.
enum class RosPictureKind { none, grey8, depth16, depth_floats, colour };
RosPictureKind ros_picture_kind(std::string_view encoding);
/// Of compressed pictures by their format ("16UC1; compressedDepth", "rgb8; jpeg compressed bgr8", "png");
/// what is depth, the name of a topic tells where the format does not.
RosPictureKind ros_compressed_kind(std::string_view format);

/// Grey of 8 or 16 bits, floats, or RGB of 8 bits: bytes in host order, without padding. Messages begin with
/// `where`.
Result<StoredImage> ros_picture(const RosImage& image, const std::string& where);
/// PNG and JPEG; depth that `compressed_depth_image_transport` packed as PNG or RVL, floats in metres.
Result<StoredImage> ros_picture(const RosCompressedImage& image, const std::string& where);

/// Depth as RVL packs it (Wilson, Fast lossless depth image compression, 2017), `pixels` of them; nothing
/// where the words end before, or hold more in one run than are left.
std::optional<std::vector<std::uint16_t>> unpack_rvl(std::string_view words, std::size_t pixels);

}  // namespace touchable
