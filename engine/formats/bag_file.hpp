#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"

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
    /// refused, as a recording that was cut has none; so is one that is encrypted. Or one of ROS 2, in MCAP
    /// (mcap_file.hpp) or in SQLite (db3_file.hpp). At most two unpacked chunks are kept in memory.
    static Result<std::unique_ptr<BagFile>> open(const SourceFile& file);

    const std::vector<BagConnection>& connections() const { return connections_; }
    /// All messages of these connections, in the order in which they were recorded.
    virtual Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) = 0;
    /// Its first bytes, or all of them, as ROS 1 serialises them.
    virtual Result<std::string> read(const BagMessage& message,
                                     std::size_t most = std::numeric_limits<std::size_t>::max()) = 0;

    const std::string& name() const { return name_; }
    /// Whether it is in a chunk of which something cannot be read, as was found out when it was to be.
    bool is_given_up(const BagMessage& message) const { return why_given_up(message.chunk) != nullptr; }
    /// The first of some messages that can be read.
    Result<std::string> read_first(std::span<const BagMessage> messages);
    /// What of it cannot be read and is left out, for a person, as far as it was looked at; empty: nothing.
    virtual std::string left_out() const;

protected:
    static constexpr std::uint64_t largest_message = 256 << 20;  // bytes

    explicit BagFile(std::string name) : name_(std::move(name)) {}
    void add_connection(BagConnection connection) { connections_.push_back(std::move(connection)); }
    Error damaged(const std::string& what) const;
    Error too_large(std::uint64_t message_size) const;
    /// Where it is the file that is wrong, what cannot be read of a chunk is left out; `why` either way.
    Error give_up_chunk(std::uint32_t chunk, Error why);
    /// Why a chunk was given up; null: it was not.
    const Error* why_given_up(std::uint32_t chunk) const;

private:
    std::string name_;
    std::vector<BagConnection> connections_;
    std::map<std::uint32_t, Error> given_up_;  // chunks
};

/// Whether a file's first bytes, 16 or all that it has, are those of a recording that BagFile reads.
bool is_recording_of_ros(std::string_view begin);

}  // namespace touchable
