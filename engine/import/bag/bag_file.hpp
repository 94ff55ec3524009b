#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/byte_source.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Who writes messages of one type to one topic.
struct BagConnection {
    std::uint32_t id = 0;
    std::string topic;
    std::string type;  ///< such as "sensor_msgs/Image"
    std::string md5;   ///< of the type's definition
};

/// Where a message is.
struct BagMessage {
    std::int64_t time_ns = 0;  ///< when it was recorded
    std::uint32_t connection = 0;
    std::uint32_t chunk = 0, offset = 0;  ///< bytes in the unpacked chunk
};

/// A recording of ROS 1 ("#ROSBAG V2.0"), plain or packed by bzip2 or LZ4, by its index. At most two unpacked
/// chunks are kept in memory.
class BagFile {
public:
    /// Refuses one without its index, as a recording that was cut is, and one that is encrypted.
    static Result<std::unique_ptr<BagFile>> open(const SourceFile& file);

    const std::vector<BagConnection>& connections() const { return connections_; }
    /// All messages of these connections, in the order in which they were recorded.
    Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections);
    /// Its first bytes, or all of them, as ROS serialises them.
    Result<std::string> read(const BagMessage& message,
                             std::size_t most = std::numeric_limits<std::size_t>::max());

    const std::string& name() const { return name_; }

private:
    struct Chunk {
        std::uint64_t at = 0;
        std::vector<std::uint32_t> connections;  ///< that have messages in it
        // Of its own record; read when first asked for.
        bool is_read = false;
        std::string compression;
        std::uint64_t data_at = 0;
        std::uint32_t packed = 0, size = 0;
    };
    struct Unpacked {
        std::uint32_t chunk;
        std::string bytes;
        std::unique_ptr<ByteSource> source;
    };
    explicit BagFile(std::string name) : name_(std::move(name)) {}
    Result<void> read_index();
    Result<void> read_chunk(Chunk& chunk);
    Result<void> find_messages(std::uint32_t number, std::span<const std::uint32_t> connections,
                               std::vector<BagMessage>& found);
    Result<ByteSource*> unpacked(std::uint32_t number);
    Error damaged(const std::string& what) const;
    Error unread(const Error& why) const;

    std::string name_;
    std::unique_ptr<ByteSource> bytes_;
    std::vector<BagConnection> connections_;
    std::vector<Chunk> chunks_;
    std::deque<Unpacked> unpacked_;  // the newest is the last
};

/// Whether a file's first bytes are those of a recording of ROS 1.
bool is_bag(std::string_view begin);

}  // namespace touchable
