// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <limits>
#include <map>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/ros_messages.hpp"

namespace touchable {

/// The publisher of messages of one type to one topic.
struct BagConnection {
    std::uint32_t id = 0;
    std::string topic;
    std::string type;  ///< such as "sensor_msgs/Image"
    std::string md5;   ///< of the type's definition
};

/// A message's place in the file.
struct BagMessage {
    std::int64_t time_ns = 0;  ///< when it was recorded
    std::uint32_t connection = 0;
    std::uint32_t chunk = 0;
    std::uint64_t offset = 0;  ///< bytes in the unpacked chunk
};

/// `size` bytes that `compression` ("bz2", "lz4", "zstd", or empty: none) stored as `packed` bytes of a file
/// from `at` on.
struct PackedChunk {
    std::string_view compression;
    std::uint64_t at = 0;
    std::uint32_t packed = 0, size = 0;
};

/// A recording of messages of ROS 1 or ROS 2.
class BagFile {
public:
    virtual ~BagFile() = default;
    /// Opens a recording of ROS 1 ("#ROSBAG V2.0", plain, bzip2 or LZ4) or of ROS 2 (MCAP or SQLite). A ROS 1
    /// recording needs its index, which one that was cut lacks, and must not be encrypted. At most two
    /// unpacked chunks are kept in memory.
    static Result<std::unique_ptr<BagFile>> open(const SourceFile& file);

    const std::vector<BagConnection>& connections() const { return connections_; }
    /// All messages of these connections, in the order in which they were recorded.
    virtual Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) = 0;
    /// A message's first `most` bytes, or all of them.
    virtual Result<RosMessage> read(const BagMessage& message,
                                    std::size_t most = std::numeric_limits<std::size_t>::max()) = 0;

    const std::string& name() const { return name_; }
    /// Whether an earlier read failed on damage in the message's chunk.
    bool is_given_up(const BagMessage& message) const { return why_given_up(message.chunk) != nullptr; }
    /// Reads the first of these messages that can be read. Nothing if there are none, or if the first is
    /// given up and no other can be read.
    Result<std::optional<RosMessage>> read_first(std::span<const BagMessage> messages);
    /// For a person: what reads so far found damaged and left out; empty: nothing.
    virtual std::string left_out() const;

protected:
    static constexpr std::uint64_t largest_message = 256 << 20;  // bytes

    explicit BagFile(std::string name) : name_(std::move(name)) {}
    void add_connection(BagConnection connection) { connections_.push_back(std::move(connection)); }
    /// A chunk's unpacked bytes; the newest two, depth's and colour's, are kept. An error if the size is not
    /// exactly the stated one; it says what is wrong, but not in which file.
    Result<ByteSource*> unpacked_chunk(std::uint32_t number, ByteSource& file, const PackedChunk& chunk);
    Error damaged(const std::string& what) const { return input_error(name_ + ": is damaged: " + what); }
    Error too_large(std::uint64_t message_size) const;
    /// Returns `why`. If the file is at fault (ErrorKind::input), what is damaged in the chunk is left out.
    Error give_up_chunk(std::uint32_t chunk, Error why) {
        if (why.kind == ErrorKind::input) given_up_.emplace(chunk, why);
        return why;
    }
    /// The error for which a chunk was given up; null: it was not.
    const Error* why_given_up(std::uint32_t chunk) const {
        const auto found = given_up_.find(chunk);
        return found == given_up_.end() ? nullptr : &found->second;
    }

private:
    struct Unpacked {
        std::uint32_t number;
        std::string bytes;
        std::unique_ptr<ByteSource> source;
    };

    std::string name_;
    std::vector<BagConnection> connections_;
    std::map<std::uint32_t, Error> given_up_;  // by chunk
    std::deque<Unpacked> unpacked_;            // the newest is last
};

/// Whether a file's first bytes, 16 or all that it has, are those of a recording that BagFile reads.
bool is_recording_of_ros(std::string_view begin);

/// Opens a recording in MCAP (mcap_file.cpp), as ROS 2 writes it; its chunks are plain, LZ4 or zstd. A
/// recording that was cut is read up to the cut.
Result<std::unique_ptr<BagFile>> open_mcap_file(const SourceFile& file);
bool is_mcap(std::string_view begin);

/// Opens a recording in SQLite (.db3; db3_file.cpp), as ROS 2 writes it: tables topics and messages, messages
/// in CDR. A write-ahead log beside it is not read.
Result<std::unique_ptr<BagFile>> open_db3_file(const SourceFile& file);
bool is_sqlite(std::string_view begin);

}  // namespace touchable
