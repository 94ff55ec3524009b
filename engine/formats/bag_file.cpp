#include "engine/formats/bag_file.hpp"

#include <algorithm>
#include <cstring>
#include <deque>
#include <utility>

#include "engine/base/byte_source.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/bag_chunk.hpp"
#include "engine/formats/bag_record.hpp"
#include "engine/formats/db3_file.hpp"
#include "engine/formats/mcap_file.hpp"
#include "engine/formats/sqlite_bytes.hpp"

namespace touchable {
namespace {

constexpr std::string_view magic = "#ROSBAG V";
constexpr std::string_view version = "2.0\n";
constexpr std::uint32_t largest_definition = 4 << 20;  // of a message type, bytes
constexpr std::uint32_t index_entry = 12;              // bytes: seconds, nanoseconds, offset
constexpr std::size_t kept_chunks = 2;                 // depth's and colour's

std::int64_t nanoseconds(std::uint32_t seconds, std::uint32_t rest) {
    return std::int64_t{seconds} * 1'000'000'000 + rest;
}

class RosBag final : public BagFile {
public:
    explicit RosBag(std::string name) : BagFile(std::move(name)) {}
    Result<void> open(const SourceFile& file);
    Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) override;
    Result<std::string> read(const BagMessage& message, std::size_t most) override;

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
    Result<void> read_index();
    Result<void> read_chunk(Chunk& chunk);
    Result<void> find_messages(std::uint32_t number, std::span<const std::uint32_t> connections,
                               std::vector<BagMessage>& found);
    Result<ByteSource*> unpacked(std::uint32_t number);
    Error unread(const Error& why) const;

    std::unique_ptr<ByteSource> bytes_;
    std::vector<Chunk> chunks_;
    std::deque<Unpacked> unpacked_;  // the newest is the last
};

Error RosBag::unread(const Error& why) const {
    return why.kind == ErrorKind::input ? damaged(why.message) : error_at(name(), why);
}

Result<void> RosBag::open(const SourceFile& file) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    bytes_ = std::move(bytes);
    std::string begin(magic.size() + version.size(), '\0');
    if (bytes_->size() < begin.size()) return damaged("it ends in its first bytes");
    if (auto read = bytes_->read(0, begin.data(), begin.size()); !read) return unread(read.error());
    if (!begin.ends_with(version))
        return input_error(name() + ": is a recording of ROS 1 of version " +
                           printable(std::string_view(begin).substr(magic.size())) +
                           ": must be of version 2.0 (rosbag fix makes one of an older one)");
    return read_index();
}

/// Connections and chunks, as the end of the file lists them.
Result<void> RosBag::read_index() {
    const std::uint64_t end = bytes_->size();
    const auto next = [&, this](std::uint64_t at) -> Result<BagRecord> {
        auto record = read_bag_record(*bytes_, at, end);
        if (!record) return Error{record.error().kind, name() + ": " + record.error().message};
        return record;
    };
    TRY_ASSIGN(const auto header, next(magic.size() + version.size()));
    const auto index = header.fields.number<std::uint64_t>("index_pos");
    const auto connections = header.fields.number<std::uint32_t>("conn_count"),
               chunks = header.fields.number<std::uint32_t>("chunk_count");
    if (!header.is(BagOp::bag_header) || !index || !connections || !chunks)
        return damaged("it does not begin with a bag's header");
    if (!header.fields.text("encryptor").value_or("").empty())
        return input_error(name() + ": is encrypted (" + printable(*header.fields.text("encryptor")) +
                           "): must be a plain bag");
    if (*index < header.end() || *index > end)
        return input_error(name() +
                           ": has no index, as the recorder was stopped before it wrote one, or the file is "
                           "cut: rosbag reindex makes one");
    std::uint64_t at = *index;
    for (std::uint32_t n = 0; n < *connections; ++n) {
        TRY_ASSIGN(const auto record, next(at));
        const auto id = record.fields.number<std::uint32_t>("conn");
        const auto topic = record.fields.text("topic");
        if (!record.is(BagOp::connection) || !id || !topic || record.size > largest_definition)
            return damaged("connection " + std::to_string(n) + " of its index is none");
        std::string data(record.size, '\0');
        if (auto read = bytes_->read(record.data_at, data.data(), data.size()); !read)
            return unread(read.error());
        const auto fields = BagFields::of(std::move(data));
        if (!fields) return damaged("connection " + std::to_string(n) + " of its index says nothing");
        const auto is_it = [&](const BagConnection& other) { return other.id == *id; };
        if (std::any_of(BagFile::connections().begin(), BagFile::connections().end(), is_it))
            return damaged("connection " + std::to_string(*id) + " is in its index twice");
        add_connection({*id, std::string(*topic), std::string(fields->text("type").value_or("")),
                        std::string(fields->text("md5sum").value_or(""))});
        at = record.end();
    }
    for (std::uint32_t n = 0; n < *chunks; ++n) {
        TRY_ASSIGN(const auto record, next(at));
        const auto chunk_at = record.fields.number<std::uint64_t>("chunk_pos");
        const auto count = record.fields.number<std::uint32_t>("count");
        if (!record.is(BagOp::chunk_info) || !chunk_at || !count || record.size != 8ULL * *count)
            return damaged("chunk " + std::to_string(n) + " of its index is none");
        std::vector<std::uint32_t> counts(2ULL * *count);  // connection, messages
        if (auto read = bytes_->read(record.data_at, reinterpret_cast<char*>(counts.data()), record.size);
            !read)
            return unread(read.error());
        Chunk chunk;
        chunk.at = *chunk_at;
        for (std::size_t k = 0; k < counts.size(); k += 2) chunk.connections.push_back(counts[k]);
        chunks_.push_back(std::move(chunk));
        at = record.end();
    }
    return {};
}

Result<void> RosBag::read_chunk(Chunk& chunk) {
    if (chunk.is_read) return {};
    const auto record = read_bag_record(*bytes_, chunk.at, bytes_->size());
    if (!record) return Error{record.error().kind, name() + ": " + record.error().message};
    const auto compression = record->fields.text("compression");
    const auto size = record->fields.number<std::uint32_t>("size");
    if (!record->is(BagOp::chunk) || !compression || !size)
        return damaged("there is no chunk at byte " + std::to_string(chunk.at));
    if (*compression != "none" && *compression != "bz2" && *compression != "lz4")
        return input_error(name() + ": is packed by " + printable(*compression) +
                           ": must be plain, bz2 or lz4");
    if (*compression == "none" && *size != record->size)
        return damaged("the chunk at byte " + std::to_string(chunk.at) + " has a wrong size");
    chunk.compression = *compression;
    chunk.data_at = record->data_at;
    chunk.packed = record->size;
    chunk.size = *size;
    chunk.is_read = true;
    return {};
}

/// By the records of index that follow the chunk.
Result<void> RosBag::find_messages(std::uint32_t number, std::span<const std::uint32_t> connections,
                                   std::vector<BagMessage>& found) {
    Chunk& chunk = chunks_[number];
    if (auto read = read_chunk(chunk); !read) return read;
    std::uint64_t at = chunk.data_at + chunk.packed;
    for (std::size_t n = 0; n < chunk.connections.size(); ++n) {
        const auto record = read_bag_record(*bytes_, at, bytes_->size());
        if (!record) return Error{record.error().kind, name() + ": " + record.error().message};
        const auto id = record->fields.number<std::uint32_t>("conn");
        if (!record->is(BagOp::index) || !id || record->size % index_entry != 0)
            return damaged("the chunk at byte " + std::to_string(chunk.at) + " has no index");
        at = record->end();
        if (std::find(connections.begin(), connections.end(), *id) == connections.end()) continue;
        std::vector<std::uint32_t> entries(record->size / 4);
        if (auto read = bytes_->read(record->data_at, reinterpret_cast<char*>(entries.data()), record->size);
            !read)
            return unread(read.error());
        for (std::size_t k = 0; k < entries.size(); k += 3)
            found.push_back({nanoseconds(entries[k], entries[k + 1]), *id, number, entries[k + 2]});
    }
    return {};
}

Result<std::vector<BagMessage>> RosBag::messages(std::span<const std::uint32_t> connections) {
    std::vector<BagMessage> found;
    for (std::uint32_t number = 0; number < chunks_.size(); ++number) {
        const auto& within = chunks_[number].connections;
        if (std::none_of(within.begin(), within.end(), [&](std::uint32_t id) {
                return std::find(connections.begin(), connections.end(), id) != connections.end();
            }))
            continue;
        TRY(find_messages(number, connections, found));
        if (found.size() > bytes_->size() / index_entry) return damaged("its index repeats itself");
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const BagMessage& a, const BagMessage& b) { return a.time_ns < b.time_ns; });
    return found;
}

Result<ByteSource*> RosBag::unpacked(std::uint32_t number) {
    const auto there = std::find_if(unpacked_.begin(), unpacked_.end(),
                                    [&](const Unpacked& each) { return each.chunk == number; });
    if (there != unpacked_.end()) return there->source.get();
    if (const Error* const why = why_given_up(number)) return *why;
    while (unpacked_.size() >= kept_chunks) unpacked_.pop_front();
    const Chunk& chunk = chunks_[number];
    auto bytes = unpack_bag_chunk(chunk.compression, *bytes_, chunk.data_at, chunk.packed, chunk.size);
    if (!bytes) return give_up_chunk(number, error_at(name(), bytes.error()));
    unpacked_.push_back({number, std::move(*bytes), nullptr});
    unpacked_.back().source = bytes_in_memory(unpacked_.back().bytes);
    return unpacked_.back().source.get();
}

Result<std::string> RosBag::read(const BagMessage& message, std::size_t most) {
    Chunk& chunk = chunks_[message.chunk];
    TRY(read_chunk(chunk));
    const bool is_plain = chunk.compression == "none";
    TRY_ASSIGN(const auto packed, is_plain ? Result<ByteSource*>(bytes_.get()) : unpacked(message.chunk));
    const std::uint64_t from = is_plain ? chunk.data_at : 0;
    const auto record = read_bag_record(*packed, from + message.offset, from + chunk.size);
    if (!record) return Error{record.error().kind, name() + ": " + record.error().message};
    if (!record->is(BagOp::message) || record->fields.number<std::uint32_t>("conn") != message.connection)
        return damaged("the message at byte " + std::to_string(message.offset) + " of the chunk at byte " +
                       std::to_string(chunk.at) + " is none of its connection");
    const std::size_t size = std::min<std::size_t>(record->size, most);
    if (size > largest_message) return too_large(size);
    std::string data(size, '\0');
    if (auto read = packed->read(record->data_at, data.data(), data.size()); !read)
        return unread(read.error());
    return data;
}

}  // namespace

Result<std::string> BagFile::read_first(std::span<const BagMessage> messages) {
    for (const BagMessage& each : messages) {
        auto bytes = read(each);
        if (bytes || !is_given_up(each)) return bytes;
    }
    return *why_given_up(messages.front().chunk);
}

std::string BagFile::left_out() const {
    if (given_up_.empty()) return "";
    const bool is_one = given_up_.size() == 1;
    return (is_one ? "a chunk is" : std::to_string(given_up_.size()) + " chunks are") +
           std::string(" damaged, and what cannot be read of ") + (is_one ? "it" : "them") +
           " is left out: " + given_up_.begin()->second.message;
}

Error BagFile::damaged(const std::string& what) const {
    return input_error(name() + ": is damaged: " + what);
}

Error BagFile::too_large(std::uint64_t message_size) const {
    return input_error(name() + ": has a message of " + std::to_string(message_size >> 20) +
                       " MiB: at most " + std::to_string(largest_message >> 20) + " are read");
}

Error BagFile::give_up_chunk(std::uint32_t chunk, Error why) {
    if (why.kind == ErrorKind::input) given_up_.emplace(chunk, why);
    return why;
}

const Error* BagFile::why_given_up(std::uint32_t chunk) const {
    const auto found = given_up_.find(chunk);
    return found == given_up_.end() ? nullptr : &found->second;
}

bool is_recording_of_ros(std::string_view begin) {
    return begin.starts_with(magic) || is_mcap(begin) || is_sqlite(begin);
}

Result<std::unique_ptr<BagFile>> BagFile::open(const SourceFile& file) {
    const std::string begin = first_bytes(file, 16);
    if (is_mcap(begin)) return open_mcap_file(file);
    if (is_sqlite(begin)) return open_db3_file(file);
    auto bag = std::make_unique<RosBag>(file.string());
    TRY(bag->open(file));
    return std::unique_ptr<BagFile>(std::move(bag));
}

}  // namespace touchable
