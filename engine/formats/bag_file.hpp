#pragma once

#include <deque>
#include <limits>
#include <map>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// The publisher of messages of one type to one topic.
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

/// `packed` bytes of a file from `at` on, which `compression` ("bz2", "lz4", "zstd", or empty: none) made of
/// `size` bytes.
struct PackedChunk {
    std::string_view compression;
    std::uint64_t at = 0;
    std::uint32_t packed = 0, size = 0;
};

/// A recording of messages as ROS 1 serialises them; those of ROS 2 are brought into that form
/// (ros_messages.hpp).
class BagFile {
public:
    virtual ~BagFile() = default;
    /// One of ROS 1 ("#ROSBAG V2.0"), plain or packed by bzip2 or LZ4, by its index, without which it is
    /// refused, as a recording that was cut has none; so is one that is encrypted. Or one of ROS 2, in MCAP
    /// or in SQLite. At most two unpacked chunks are kept in memory.
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
    /// What a chunk has, unpacked now or among the newest two, depth's and colour's. Refused where that is
    /// not exactly as large as it should be. An error says what is wrong, but not in which file.
    Result<ByteSource*> unpacked_chunk(std::uint32_t number, ByteSource& file, const PackedChunk& chunk);
    Error damaged(const std::string& what) const { return input_error(name_ + ": is damaged: " + what); }
    Error too_large(std::uint64_t message_size) const;
    /// Where it is the file that is wrong, what cannot be read of a chunk is left out; `why` either way.
    Error give_up_chunk(std::uint32_t chunk, Error why) {
        if (why.kind == ErrorKind::input) given_up_.emplace(chunk, why);
        return why;
    }
    /// Why a chunk was given up; null: it was not.
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
    std::map<std::uint32_t, Error> given_up_;  // chunks
    std::deque<Unpacked> unpacked_;            // the newest is the last
};

/// Whether a file's first bytes, 16 or all that it has, are those of a recording that BagFile reads.
bool is_recording_of_ros(std::string_view begin);

/// A recording in MCAP (mcap_file.cpp), as ROS 2 writes it; its chunks plain or packed by LZ4 or zstd. Of one
/// that was cut, what is there.
Result<std::unique_ptr<BagFile>> open_mcap_file(const SourceFile& file);
bool is_mcap(std::string_view begin);

/// A recording in SQLite (.db3; db3_file.cpp), as ROS 2 writes it: tables topics and messages, messages in
/// CDR. What is in a write-ahead log beside it is left out.
Result<std::unique_ptr<BagFile>> open_db3_file(const SourceFile& file);
bool is_sqlite(std::string_view begin);

}  // namespace touchable
