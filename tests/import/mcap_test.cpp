// Recordings of ROS 2 in MCAP, written from what mcap.dev/spec and OMG's CDR say.
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <map>

#include "tests/clip/clip_fixture.hpp"
#include "tests/import/bag_bytes.hpp"
#include "tests/import/ros2_messages.hpp"
#include "tests/limited_memory.hpp"

namespace touchable::test {
namespace {

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

McapBytes ros2_mcap() {
    McapBytes mcap;
    std::map<std::string, std::uint16_t> channels;
    for (const Ros2Message& each : ros2_recording()) {
        auto& channel = channels[each.topic];
        if (channel == 0) channel = mcap.add_channel(each.topic, each.type);
        mcap.add(channel, each.time_ns, each.bytes);
    }
    return mcap;
}

TEST(Mcap, ARecordingOfRos2OpensHoweverItIsPacked) {
    const TemporaryFolder folder;
    const McapBytes mcap = ros2_mcap();
    for (const McapOptions& options :
         {McapOptions{}, McapOptions{"lz4"}, McapOptions{"zstd"}, McapOptions{"", false},
          McapOptions{"zstd", true, false}, McapOptions{"lz4", true, true, false},
          McapOptions{"zstd", true, false, false}}) {
        SCOPED_TRACE(options.compression + (options.has_chunks ? " chunks" : "") +
                     (options.has_index ? " index" : "") + (options.has_summary ? " summary" : ""));
        write_bytes(folder / "x.mcap", mcap.file(options));
        const auto clip = open_clip(folder / "x.mcap");
        ASSERT_EQ(message(clip), "");
        expect_ros2_recording(**clip);
    }
}

TEST(Mcap, WhatIsCutIsReadUpToThereAndDamageIsTold) {
    const TemporaryFolder folder;
    const std::string whole = ros2_mcap().file({});
    int opened = 0;
    for (std::size_t length = 8; length < whole.size(); length += 61) {
        write_bytes(folder / "x.mcap", whole.substr(0, length));
        const auto clip = open_clip(folder / "x.mcap");
        opened += bool(clip);
        if (!clip) {
            EXPECT_TRUE(is_refused(clip, "x.mcap"));
        }
    }
    EXPECT_GT(opened, 5);
    Numbers numbers(7);
    const std::string packed = ros2_mcap().file({"lz4"});
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
    EXPECT_TRUE(is_refused(open_clip(folder / "x.mcap"), "x.mcap"));
}

/// As a clip is that lost its first frame, and says so.
void expect_last_two_frames(const std::filesystem::path& file) {
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    expect_ros2_recording(**clip, 2);
    const auto told = clip_notes(**clip);
    EXPECT_EQ(std::count_if(told.begin(), told.end(),
                            [](const std::string& note) {
                                return note.find("a chunk is damaged") != std::string::npos;
                            }),
              1);
}

TEST(Mcap, WhatIsInADamagedChunkIsLeftOutAndTheRestIsRead) {
    const TemporaryFolder folder;
    const std::map<std::string, std::string> begins{{"lz4", "\x04\x22\x4d\x18"},
                                                    {"zstd", "\x28\xb5\x2f\xfd"}};
    for (const auto& [compression, begin] : begins)
        for (const bool has_index : {true, false})
            for (const bool has_summary : {true, false}) {
                SCOPED_TRACE(compression);
                std::string bytes = ros2_mcap().file({compression, true, has_index, has_summary});
                bytes[bytes.find(begin)] = 'x';  // of the first chunk
                write_bytes(folder / "x.mcap", bytes);
                expect_last_two_frames(folder / "x.mcap");
            }
    // A plain chunk, in which the first message of depth is none.
    std::string bytes = ros2_mcap().file({});
    std::string time;
    put(time, ros2_recording().front().time_ns);
    const std::size_t op_and_length = 9, channel_and_number = 6;
    const auto at = bytes.find(time + time) - op_and_length - channel_and_number;
    ASSERT_EQ(bytes[at], 5);
    bytes[at] = 8;
    write_bytes(folder / "x.mcap", bytes);
    expect_last_two_frames(folder / "x.mcap");
}

/// A hole in a file is zeros that cost nothing to write.
TEST(Mcap, AHoleInAFileTakesNeitherMemoryNorTime) {
    const TemporaryFolder folder;
    const auto file = folder / "x.mcap";
    const std::string whole = ros2_mcap().file({"zstd"});
    const std::uintmax_t hole = std::uintmax_t{1} << 40U;
    write_bytes(file, whole);
    std::filesystem::resize_file(file, whole.size() + hole);
    {
        const auto clip = open_clip(file);
        ASSERT_EQ(message(clip), "");
        expect_ros2_recording(**clip);
    }
    // An index, of a chunk that says to have 3 GiB of messages.
    std::string bytes = whole.substr(0, whole.rfind(mcap_record(15, std::string(4, '\0')))), chunk(16, '\0'),
                index;
    put(chunk, std::uint64_t{3} << 30U);
    put(chunk, std::uint32_t{0});
    chunk += mcap_text("zstd");
    put(chunk, std::uint64_t{1});
    bytes += mcap_record(6, chunk + "x") + '\7';
    const std::uint32_t pairs = 100'000'000;
    put(bytes, std::uint64_t{6 + 16 * std::uint64_t{pairs}});
    put(bytes, std::uint16_t{1});
    put(bytes, 16 * pairs);
    write_bytes(file, bytes);
    std::filesystem::resize_file(file, whole.size() + hole);
    const LimitedMemory limited(512);
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    expect_ros2_recording(**clip);
}

}  // namespace
}  // namespace touchable::test
