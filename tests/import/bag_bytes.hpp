// SPDX-License-Identifier: Apache-2.0
#pragma once

// Recordings of ROS 1 and messages of ROS 2, byte by byte.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace touchable {
class ClipReader;
}

namespace touchable::test {

/// Numbers and texts as ROS 1 serialises them, appended to bytes.
template <class Number>
void put(std::string& bytes, Number number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}
void put_text(std::string& bytes, std::string_view text);

/// sensor_msgs/Image.
struct ImageMessage {
    std::int64_t stamp_ns = 0;
    int width = 0, height = 0;
    std::string encoding;
    bool is_big_endian = false;
    std::uint32_t step = 0;
    std::string data;

    std::string bytes() const;
};
/// sensor_msgs/CompressedImage.
std::string compressed_message(std::int64_t stamp_ns, const std::string& format, const std::string& data);
/// sensor_msgs/CameraInfo; a rectified camera, where it is another one, in `projection`.
std::string camera_message(int width, int height, const std::vector<double>& fx_fy_cx_cy,
                           const std::vector<double>& projection = {},
                           const std::vector<double>& distortion = {});
/// geometry_msgs/Transform.
std::string transform_message(const std::vector<double>& translation, const std::vector<double>& quaternion);

/// A recording of ROS 1, written from what http://wiki.ros.org/Bags/Format/2.0 says.
class BagBytes {
public:
    /// Appends a message.
    void add(const std::string& topic, const std::string& type, std::int64_t time_ns,
             const std::string& message);
    /// The file; `compression` "none", "bz2" or "lz4", a new chunk for each so many messages.
    std::string file(const std::string& compression, std::size_t messages_per_chunk = 4) const;

private:
    struct Message {
        std::uint32_t connection;
        std::int64_t time_ns;
        std::string bytes;
    };
    struct Connection {
        std::string topic, type;
    };
    std::string connection_record(std::uint32_t id) const;

    std::vector<Connection> connections_;
    std::vector<Message> messages_;
};

/// A message of ROS 2, in CDR; from here on of ros2_messages.cpp.
struct Ros2Message {
    std::string topic, type;  ///< "sensor_msgs/msg/Image"
    std::int64_t time_ns;     ///< when it was recorded
    std::string bytes;
};

/// Depth of 16x12, its camera, colour, and what is no picture: three of each, in the order of time.
std::vector<Ros2Message> ros2_recording();

/// A record of MCAP, and a text in one, as mcap.dev/spec has them.
std::string mcap_record(int op, const std::string& content);
std::string mcap_text(const std::string& words);
struct McapOptions {
    std::string compression{};  ///< "", "lz4", "zstd"
    bool has_chunks = true, has_index = true, has_summary = true;
};
/// A recording of these messages, three a chunk.
std::string mcap_file(const std::vector<Ros2Message>& messages, const McapOptions& options = {});

/// Expects a clip of the last `frames` of these: codes, times, colour, and every point
/// where an unprojection written here has it.
void expect_ros2_recording(ClipReader& clip, int frames = 3);

}  // namespace touchable::test
