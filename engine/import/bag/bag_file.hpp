#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/given_file.hpp"
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
    std::uint32_t chunk = 0;
    std::uint64_t offset = 0;  ///< bytes in the unpacked chunk
};

/// A recording of messages as ROS 1 serialises them.
class BagFile {
public:
    virtual ~BagFile() = default;
    /// One of ROS 1 ("#ROSBAG V2.0"), plain or packed by bzip2 or LZ4, by its index, without which it is
    /// refused, as a recording that was cut has none; so is one that is encrypted. Or one in MCAP
    /// (mcap_file.hpp). At most two unpacked chunks are kept in memory.
    static Result<std::unique_ptr<BagFile>> open(const SourceFile& file);

    const std::vector<BagConnection>& connections() const { return connections_; }
    /// All messages of these connections, in the order in which they were recorded.
    virtual Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) = 0;
    /// Its first bytes, or all of them, as ROS 1 serialises them.
    virtual Result<std::string> read(const BagMessage& message,
                                     std::size_t most = std::numeric_limits<std::size_t>::max()) = 0;

    const std::string& name() const { return name_; }

protected:
    explicit BagFile(std::string name) : name_(std::move(name)) {}
    void add_connection(BagConnection connection) { connections_.push_back(std::move(connection)); }

private:
    std::string name_;
    std::vector<BagConnection> connections_;
};

/// Whether a file's first bytes are those of a recording of ROS 1.
bool is_bag(std::string_view begin);

}  // namespace touchable
