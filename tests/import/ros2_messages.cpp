// SPDX-License-Identifier: Apache-2.0
#include "tests/import/bag_bytes.hpp"

#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>

#include "engine/picture/image.hpp"
#include "tests/picture/results.hpp"

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

std::string mcap_chunk(const std::string& records, const std::string& compression) {
    std::string packed = records;
    if (compression == "zstd") {
        packed.resize(ZSTD_compressBound(records.size()));
        packed.resize(ZSTD_compress(packed.data(), packed.size(), records.data(), records.size(), 1));
    } else if (compression == "lz4") {
        packed.resize(LZ4F_compressFrameBound(records.size(), nullptr));
        packed.resize(
            LZ4F_compressFrame(packed.data(), packed.size(), records.data(), records.size(), nullptr));
    }
    std::string content(16, '\0');
    put(content, static_cast<std::uint64_t>(records.size()));
    put(content, std::uint32_t{0});
    content += mcap_text(compression);
    put(content, static_cast<std::uint64_t>(packed.size()));
    return mcap_record(6, content + packed);
}

}  // namespace

std::string mcap_record(int op, const std::string& content) {
    std::string record(1, static_cast<char>(op));
    put(record, static_cast<std::uint64_t>(content.size()));
    return record + content;
}

std::string mcap_text(const std::string& words) {
    std::string bytes;
    put_text(bytes, words);
    return bytes;
}

std::string mcap_file(const std::vector<Ros2Message>& messages, const McapOptions& options) {
    std::map<std::string, std::uint16_t> channels;
    std::string definitions;
    for (const Ros2Message& each : messages) {
        std::uint16_t& channel = channels[each.topic];
        if (channel != 0) continue;
        channel = static_cast<std::uint16_t>(channels.size());
        std::string id;
        put(id, channel);
        definitions +=
            mcap_record(3, id + mcap_text(each.type) + mcap_text("ros2msg") + mcap_text("its definition")) +
            mcap_record(4, id + id + mcap_text(each.topic) + mcap_text("cdr") + mcap_text(""));
    }
    const std::string magic("\x89MCAP0\r\n", 8);
    std::string bytes = magic + mcap_record(1, mcap_text("ros2") + mcap_text("a test"));
    if (!options.has_chunks) bytes += definitions;
    for (std::size_t first = 0; first < messages.size(); first += 3) {
        std::string records = options.has_chunks ? definitions : "", indices;
        for (std::size_t k = first; k < std::min(first + 3, messages.size()); ++k) {
            const auto& [topic, type, time, message] = messages[k];
            std::string index, content;
            put(index, channels[topic]);
            put(index, std::uint32_t{16});
            put(index, time);
            put(index, static_cast<std::uint64_t>(records.size()));
            indices += mcap_record(7, index);
            put(content, channels[topic]);
            put(content, std::uint32_t{0});
            put(content, time);
            put(content, time);
            records += mcap_record(5, content + message);
        }
        bytes += options.has_chunks ? mcap_chunk(records, options.compression) : records;
        if (options.has_chunks && options.has_index) bytes += indices;
    }
    bytes += mcap_record(15, std::string(4, '\0'));
    if (options.has_summary) bytes += definitions;
    return bytes + mcap_record(2, std::string(20, '\0')) + magic;
}

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
    const auto read = must(read_all(clip));
    ASSERT_EQ(read.size(), static_cast<std::size_t>(frames));
    const Scene& scene = clip.scene();
    EXPECT_EQ(scene.rate.num, 10);
    for (int k = 0; k < frames; ++k) {
        const RawFrame& frame = read[static_cast<std::size_t>(k)];
        const int n = 3 - frames + k;
        EXPECT_EQ(frame.colour.sample(3, 4, 1), 40 + n);
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 16; ++x) {
                const std::uint16_t code = frame.depth.sample(x, y);
                ASSERT_EQ(code, ros2_code(n, x, y));
                ASSERT_EQ(scene.depth.is_valid(code), code > 0);
                if (code == 0) continue;
                ASSERT_TRUE(is_at(scene, code, {20, 21, 7.75, 5.25}, x, y, 0.001 * code, 1e-12));
            }
    }
}

}  // namespace touchable::test
