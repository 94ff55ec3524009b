// Recordings of ROS 2 in MCAP, written from what mcap.dev/spec and OMG's CDR say.
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/picture/image_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/bag_bytes.hpp"

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

std::string mcap_record(int op, const std::string& content) {
    std::string record(1, static_cast<char>(op));
    put(record, static_cast<std::uint64_t>(content.size()));
    return record + content;
}

std::string mcap_text(const std::string& words) {
    std::string bytes;
    put(bytes, static_cast<std::uint32_t>(words.size()));
    return bytes + words;
}

struct McapOptions {
    std::string compression{};  ///< "", "lz4", "zstd"
    bool has_chunks = true, has_index = true, has_summary = true;
};

class McapBytes {
public:
    std::uint16_t add_channel(const std::string& topic, const std::string& type) {
        ++channels_;
        std::string schema, channel;
        put(schema, channels_);
        schema += mcap_text(type) + mcap_text("ros2msg") + mcap_text("its definition");
        put(channel, channels_);
        put(channel, channels_);
        channel += mcap_text(topic) + mcap_text("cdr") + mcap_text("");
        definitions_ += mcap_record(3, schema) + mcap_record(4, channel);
        return channels_;
    }
    void add(std::uint16_t channel, std::int64_t time_ns, const std::string& message) {
        std::string content;
        put(content, channel);
        put(content, std::uint32_t{0});
        put(content, static_cast<std::uint64_t>(time_ns));
        put(content, static_cast<std::uint64_t>(time_ns));
        messages_.push_back({channel, time_ns, mcap_record(5, content + message)});
    }
    /// Three messages a chunk.
    std::string file(const McapOptions& options) const {
        const std::string magic("\x89MCAP0\r\n", 8);
        std::string bytes = magic + mcap_record(1, mcap_text("ros2") + mcap_text("a test"));
        if (!options.has_chunks) bytes += definitions_;
        for (std::size_t first = 0; first < messages_.size(); first += 3) {
            std::string records = options.has_chunks ? definitions_ : "", indices;
            for (std::size_t k = first; k < std::min(first + 3, messages_.size()); ++k) {
                std::string index;
                put(index, messages_[k].channel);
                put(index, std::uint32_t{16});
                put(index, static_cast<std::uint64_t>(messages_[k].time_ns));
                put(index, static_cast<std::uint64_t>(records.size()));
                indices += mcap_record(7, index);
                records += messages_[k].record;
            }
            bytes += options.has_chunks ? chunk(records, options.compression) : records;
            if (options.has_chunks && options.has_index) bytes += indices;
        }
        bytes += mcap_record(15, std::string(4, '\0'));
        if (options.has_summary) bytes += definitions_;
        return bytes + mcap_record(2, std::string(20, '\0')) + magic;
    }

private:
    struct Message {
        std::uint16_t channel;
        std::int64_t time_ns;
        std::string record;
    };
    static std::string chunk(const std::string& records, const std::string& compression) {
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

    std::uint16_t channels_ = 0;
    std::string definitions_;
    std::vector<Message> messages_;
};

int mcap_code(int n, int x, int y) {
    return (x + y) % 5 == 0 ? 0 : 700 + 10 * n + 3 * x + 20 * y;
}

/// Depth of 16x12, its camera, and colour, three frames of each.
McapBytes ros2_recording() {
    McapBytes mcap;
    const auto depth = mcap.add_channel("/camera/depth/image_raw", "sensor_msgs/msg/Image"),
               camera = mcap.add_channel("/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo"),
               colour =
                   mcap.add_channel("/camera/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
               other = mcap.add_channel("/tf", "tf2_msgs/msg/TFMessage");
    const TemporaryFolder folder;
    for (int n = 0; n < 3; ++n) {
        const std::int64_t time = 1'700'000'000'000'000'000 + n * 100'000'000LL;
        std::string values;
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 16; ++x) put(values, static_cast<std::uint16_t>(mcap_code(n, x, y)));
        mcap.add(depth, time + 5,
                 CdrBytes()
                     .header(time)
                     .number(12U)
                     .number(16U)
                     .text("16UC1")
                     .number(std::uint8_t{0})
                     .number(32U)
                     .data(values)
                     .message());
        CdrBytes info;
        info.header(time).number(12U).number(16U).text("plumb_bob").number(5U);
        for (int k = 0; k < 5; ++k) info.number(0.0);
        for (const double each : {20.0, 0.0, 7.75, 0.0, 21.0, 5.25, 0.0, 0.0, 1.0}) info.number(each);
        for (const double each : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) info.number(each);
        for (const double each : {20.0, 0.0, 7.75, 0.0, 0.0, 21.0, 5.25, 0.0, 0.0, 0.0, 1.0, 0.0})
            info.number(each);
        for (int k = 0; k < 6; ++k) info.number(0U);
        mcap.add(camera, time + 6, info.number(std::uint8_t{0}).message());
        Samples memory(3 * 16 * 12, static_cast<std::uint8_t>(40 + n));
        EXPECT_EQ(message(write_png(folder / "c.png", PlaneView{memory.data(), 48, 16, 12, 1, 3})), "");
        mcap.add(colour, time + 7,
                 CdrBytes()
                     .header(time)
                     .text("rgb8; png compressed rgb8")
                     .data(read_bytes(folder / "c.png"))
                     .message());
        mcap.add(other, time + 8, std::string(30, '\7'));
    }
    return mcap;
}

TEST(Mcap, ARecordingOfRos2OpensHoweverItIsPacked) {
    const TemporaryFolder folder;
    const McapBytes mcap = ros2_recording();
    for (const McapOptions& options :
         {McapOptions{}, McapOptions{"lz4"}, McapOptions{"zstd"}, McapOptions{"", false},
          McapOptions{"zstd", true, false}, McapOptions{"lz4", true, true, false},
          McapOptions{"zstd", true, false, false}}) {
        SCOPED_TRACE(options.compression + (options.has_chunks ? " chunks" : "") +
                     (options.has_index ? " index" : "") + (options.has_summary ? " summary" : ""));
        write_bytes(folder / "x.mcap", mcap.file(options));
        const auto clip = open_clip(folder / "x.mcap");
        ASSERT_EQ(message(clip), "");
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 3U);
        const Scene& scene = (*clip)->scene();
        EXPECT_EQ(scene.rate.num, 10);
        for (int n = 0; n < 3; ++n) {
            const RawFrame& frame = (*frames)[static_cast<std::size_t>(n)];
            EXPECT_EQ(frame.colour.sample(3, 4, 1), 40 + n);
            for (int y = 0; y < 12; ++y)
                for (int x = 0; x < 16; ++x) {
                    const std::uint16_t code = frame.depth.sample(x, y);
                    ASSERT_EQ(code, mcap_code(n, x, y));
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
}

TEST(Mcap, WhatIsCutIsReadUpToThereAndDamageIsTold) {
    const TemporaryFolder folder;
    const std::string whole = ros2_recording().file({});
    int opened = 0;
    for (std::size_t length = 8; length < whole.size(); length += 61) {
        write_bytes(folder / "x.mcap", whole.substr(0, length));
        const auto clip = open_clip(folder / "x.mcap");
        opened += clip.ok();
        if (!clip) {
            EXPECT_NE(message(clip).find("x.mcap"), std::string::npos);
        }
    }
    EXPECT_GT(opened, 5);
    Numbers numbers(7);
    const std::string packed = ros2_recording().file({"lz4"});
    for (int n = 0; n < 300; ++n) {
        std::string damaged = packed;
        for (int k = 0; k < 3; ++k)
            damaged[static_cast<std::size_t>(8 + numbers.below(static_cast<int>(packed.size()) - 8))] =
                static_cast<char>(numbers.below(256));
        write_bytes(folder / "x.mcap", damaged);
        if (const auto clip = open_clip(folder / "x.mcap"); clip) (void)read_all(**clip);
    }
    McapBytes none;
    none.add(none.add_channel("/tf", "tf2_msgs/msg/TFMessage"), 1, "what");
    write_bytes(folder / "x.mcap", none.file({}));
    EXPECT_NE(message(open_clip(folder / "x.mcap")).find("x.mcap"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
