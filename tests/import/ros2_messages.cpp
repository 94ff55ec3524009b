#include <bzlib.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <algorithm>
#include <utility>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/ros2_messages.hpp"

namespace touchable::test {
namespace {

/// Values of CDR, low byte first: numbers stand at multiples of their size, texts end with a zero.
class CdrBytes {
public:
    template <class Number>
    CdrBytes& number(Number value) {
        while (bytes_.size() % sizeof value != 0) bytes_ += '\0';
        put(bytes_, value);
        return *this;
    }
    CdrBytes& text(const std::string& words) {
        number(static_cast<std::uint32_t>(words.size() + 1));
        bytes_ += words + '\0';
        return *this;
    }
    CdrBytes& data(const std::string& values) {
        number(static_cast<std::uint32_t>(values.size()));
        bytes_ += values;
        return *this;
    }
    CdrBytes& header(std::int64_t stamp_ns) {
        return number(static_cast<std::int32_t>(stamp_ns / 1'000'000'000))
            .number(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000))
            .text("camera_optical");
    }
    std::string message() const { return std::string("\0\1\0\0", 4) + bytes_; }

private:
    std::string bytes_;
};

int ros2_code(int n, int x, int y) {
    return (x + y) % 5 == 0 ? 0 : 700 + 10 * n + 3 * x + 20 * y;
}

std::string ros2_depth(int n, std::int64_t time) {
    std::string values;
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x) put(values, static_cast<std::uint16_t>(ros2_code(n, x, y)));
    return CdrBytes()
        .header(time)
        .number(12U)
        .number(16U)
        .text("16UC1")
        .number(std::uint8_t{0})
        .number(32U)
        .data(values)
        .message();
}

std::string ros2_camera(std::int64_t time) {
    CdrBytes info;
    info.header(time).number(12U).number(16U).text("plumb_bob").number(5U);
    for (int k = 0; k < 5; ++k) info.number(0.0);
    for (const double each : {20.0, 0.0, 7.75, 0.0, 21.0, 5.25, 0.0, 0.0, 1.0}) info.number(each);
    for (const double each : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) info.number(each);
    for (const double each : {20.0, 0.0, 7.75, 0.0, 0.0, 21.0, 5.25, 0.0, 0.0, 0.0, 1.0, 0.0})
        info.number(each);
    for (int k = 0; k < 6; ++k) info.number(0U);
    return info.number(std::uint8_t{0}).message();
}

std::string ros2_colour(int n, std::int64_t time) {
    const TemporaryFolder folder;
    Samples memory(3 * 16 * 12, static_cast<std::uint8_t>(40 + n));
    EXPECT_EQ(message(write_png(folder / "c.png", PlaneView{memory.data(), 48, 16, 12, 1, 3})), "");
    return CdrBytes()
        .header(time)
        .text("rgb8; png compressed rgb8")
        .data(read_bytes(folder / "c.png"))
        .message();
}

}  // namespace

std::vector<Ros2Message> ros2_recording() {
    std::vector<Ros2Message> all;
    for (int n = 0; n < 3; ++n) {
        const std::int64_t time = 1'700'000'000'000'000'000 + n * 100'000'000LL;
        all.push_back({"/camera/depth/image_raw", "sensor_msgs/msg/Image", time + 5, ros2_depth(n, time)});
        all.push_back(
            {"/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", time + 6, ros2_camera(time)});
        all.push_back({"/camera/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage", time + 7,
                       ros2_colour(n, time)});
        all.push_back({"/tf", "tf2_msgs/msg/TFMessage", time + 8, std::string(30, '\7')});
    }
    return all;
}

void expect_ros2_recording(ClipReader& clip, int frames) {
    const auto read = read_all(clip);
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), static_cast<std::size_t>(frames));
    const Scene& scene = clip.scene();
    EXPECT_EQ(scene.rate.num, 10);
    for (int k = 0; k < frames; ++k) {
        const RawFrame& frame = (*read)[static_cast<std::size_t>(k)];
        const int n = 3 - frames + k;
        EXPECT_EQ(frame.colour.sample(3, 4, 1), 40 + n);
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 16; ++x) {
                const std::uint16_t code = frame.depth.sample(x, y);
                ASSERT_EQ(code, ros2_code(n, x, y));
                ASSERT_EQ(scene.depth.is_valid(code), code > 0);
                if (code == 0) continue;
                const double z = 0.001 * code;
                const auto point = unproject(scene.camera, x, y, scene.depth.depth(code));
                ASSERT_NEAR(point.x, (x - 7.75) / 20 * z, 1e-12);
                ASSERT_NEAR(point.y, -(y - 5.25) / 21 * z, 1e-12);
                ASSERT_NEAR(point.z, -z, 1e-12);
            }
    }
}

}  // namespace touchable::test
namespace touchable::test {
namespace {

constexpr char md5_of_image[] = "060021388200f6f0f447d0fcd9c64743";

std::string md5_of(const std::string& type) {
    const std::map<std::string, std::string> sums{
        {"sensor_msgs/Image", md5_of_image},
        {"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f"},
        {"sensor_msgs/CameraInfo", "c9a58c1b0b154e0e6da7578cb991d214"},
        {"std_msgs/Float32", "73fcbf46b49191e672908e50842a83d4"},
        {"geometry_msgs/Transform", "ac9eff44abf714214112b05d54a3cf9b"},
        {"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"}};
    const auto found = sums.find(type);
    return found == sums.end() ? "00000000000000000000000000000000" : found->second;
}

std::string field(const std::string& name, const std::string& value) {
    std::string bytes;
    put_text(bytes, name + "=" + value);
    return bytes;
}
template <class Number>
std::string number_field(const std::string& name, Number number) {
    std::string value;
    put(value, number);
    return field(name, value);
}
std::string time_bytes(std::int64_t ns) {
    std::string bytes;
    put(bytes, static_cast<std::uint32_t>(ns / 1'000'000'000));
    put(bytes, static_cast<std::uint32_t>(ns % 1'000'000'000));
    return bytes;
}
std::string record(int op, const std::string& fields, const std::string& data) {
    std::string bytes;
    put_text(bytes, fields + number_field("op", static_cast<std::uint8_t>(op)));
    put_text(bytes, data);
    return bytes;
}

std::string packed(const std::string& bytes, const std::string& compression) {
    if (compression == "none") return bytes;
    std::string to;
    if (compression == "bz2") {
        to.resize(bytes.size() + bytes.size() / 50 + 700);
        auto size = static_cast<unsigned>(to.size());
        BZ2_bzBuffToBuffCompress(to.data(), &size, const_cast<char*>(bytes.data()),
                                 static_cast<unsigned>(bytes.size()), 9, 0, 0);
        to.resize(size);
    } else {
        to.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
        to.resize(LZ4F_compressFrame(to.data(), to.size(), bytes.data(), bytes.size(), nullptr));
    }
    return to;
}

void put_header(std::string& bytes, std::int64_t stamp_ns) {
    put(bytes, std::uint32_t{7});
    bytes += time_bytes(stamp_ns);
    put_text(bytes, "a_frame");
}

}  // namespace

void put_text(std::string& bytes, std::string_view text) {
    put(bytes, static_cast<std::uint32_t>(text.size()));
    bytes += text;
}

std::string ImageMessage::bytes() const {
    std::string all;
    put_header(all, stamp_ns);
    put(all, static_cast<std::uint32_t>(height));
    put(all, static_cast<std::uint32_t>(width));
    put_text(all, encoding);
    put(all, static_cast<std::uint8_t>(is_big_endian));
    put(all, step);
    put_text(all, data);
    return all;
}

std::string compressed_message(std::int64_t stamp_ns, const std::string& format, const std::string& data) {
    std::string all;
    put_header(all, stamp_ns);
    put_text(all, format);
    put_text(all, data);
    return all;
}

std::string camera_message(int width, int height, const std::vector<double>& camera,
                           const std::vector<double>& projection, const std::vector<double>& distortion) {
    std::string all;
    put_header(all, 0);
    put(all, static_cast<std::uint32_t>(height));
    put(all, static_cast<std::uint32_t>(width));
    put_text(all, "plumb_bob");
    put(all, static_cast<std::uint32_t>(distortion.size()));
    for (const double term : distortion) put(all, term);
    const std::vector<double>& p = projection.empty() ? camera : projection;
    for (const double term : {camera[0], 0., camera[2], 0., camera[1], camera[3], 0., 0., 1.}) put(all, term);
    for (const double term : {1., 0., 0., 0., 1., 0., 0., 0., 1.}) put(all, term);
    for (const double term : {p[0], 0., p[2], 0., 0., p[1], p[3], 0., 0., 0., 1., 0.}) put(all, term);
    all += std::string(4 * 6 + 1, '\0');
    return all;
}

std::string transform_message(const std::vector<double>& translation, const std::vector<double>& quaternion) {
    std::string all;
    for (const double term : translation) put(all, term);
    for (const double term : quaternion) put(all, term);
    return all;
}

void BagBytes::add(const std::string& topic, const std::string& type, std::int64_t time_ns,
                   const std::string& message) {
    const auto there = std::find_if(connections_.begin(), connections_.end(), [&](const Connection& each) {
        return each.topic == topic && each.type == type;
    });
    const auto id = static_cast<std::uint32_t>(there - connections_.begin());
    if (there == connections_.end()) connections_.push_back({topic, type});
    messages_.push_back({id, time_ns, message});
}

std::string BagBytes::connection_record(std::uint32_t id) const {
    const Connection& connection = connections_[id];
    return record(7, number_field("conn", id) + field("topic", connection.topic),
                  field("topic", connection.topic) + field("type", connection.type) +
                      field("md5sum", md5_of(connection.type)) + field("message_definition", ""));
}

std::string BagBytes::file(const std::string& compression, std::size_t messages_per_chunk) const {
    std::string chunks, infos;
    const std::string begin = "#ROSBAG V2.0\n";
    constexpr std::size_t header_size = 4096;
    std::uint32_t count = 0;
    for (std::size_t first = 0; first < messages_.size(); first += messages_per_chunk, ++count) {
        const std::size_t end = std::min(first + messages_per_chunk, messages_.size());
        std::string chunk;
        std::map<std::uint32_t, std::string> entries;
        for (std::size_t n = first; n < end; ++n) {
            const Message& message = messages_[n];
            if (entries.find(message.connection) == entries.end())
                chunk += connection_record(message.connection);
            std::string& index = entries[message.connection];
            index += time_bytes(message.time_ns);
            put(index, static_cast<std::uint32_t>(chunk.size()));
            chunk += record(
                2, number_field("conn", message.connection) + field("time", time_bytes(message.time_ns)),
                message.bytes);
        }
        const std::uint64_t at = begin.size() + header_size + chunks.size();
        chunks += record(5,
                         field("compression", compression) +
                             number_field("size", static_cast<std::uint32_t>(chunk.size())),
                         packed(chunk, compression));
        std::string counts;
        for (const auto& [id, index] : entries) {
            const auto messages = static_cast<std::uint32_t>(index.size() / 12);
            chunks += record(4,
                             number_field("ver", std::uint32_t{1}) + number_field("conn", id) +
                                 number_field("count", messages),
                             index);
            put(counts, id);
            put(counts, messages);
        }
        infos += record(6,
                        number_field("ver", std::uint32_t{1}) + number_field("chunk_pos", at) +
                            field("start_time", time_bytes(messages_[first].time_ns)) +
                            field("end_time", time_bytes(messages_[end - 1].time_ns)) +
                            number_field("count", static_cast<std::uint32_t>(entries.size())),
                        counts);
    }
    const std::string fields =
        number_field("index_pos", std::uint64_t{begin.size() + header_size + chunks.size()}) +
        number_field("conn_count", static_cast<std::uint32_t>(connections_.size())) +
        number_field("chunk_count", count);
    const std::size_t unpadded = record(3, fields, "").size();
    std::string all = begin + record(3, fields, std::string(header_size - unpadded, ' ')) + chunks;
    for (std::uint32_t id = 0; id < connections_.size(); ++id) all += connection_record(id);
    return all + infos;
}

}  // namespace touchable::test
