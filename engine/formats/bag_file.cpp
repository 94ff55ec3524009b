// SPDX-License-Identifier: Apache-2.0
// Unpacks chunks, and reads recordings of ROS 1: records of fields and data, which an index at the end lists.

#include "engine/formats/bag_file.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::uint32_t largest_chunk = 128 << 20;  // recorders write chunks of one to ten MiB

/// Unpacks `from`, which fills `to`; false if it is damaged. Bytes behind the end do not matter.
bool unpack_bz2(std::string& from, std::string& to) {
    auto size = static_cast<unsigned>(to.size());
    return BZ2_bzBuffToBuffDecompress(to.data(), &size, from.data(), static_cast<unsigned>(from.size()), 0,
                                      0) == BZ_OK &&
           size == to.size();
}

bool unpack_lz4(std::string_view from, std::string& to) {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
    const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> closer(
        context, LZ4F_freeDecompressionContext);
    std::size_t filled = 0, wanted = 1;
    while (wanted != 0) {
        std::size_t taken = from.size(), given = to.size() - filled;
        wanted = LZ4F_decompress(context, to.data() + filled, &given, from.data(), &taken, nullptr);
        if (LZ4F_isError(wanted) || (taken == 0 && given == 0)) return false;
        filled += given;
        from.remove_prefix(taken);
    }
    return filled == to.size();
}

/// Of one or several frames.
bool unpack_zstd(std::string_view from, std::string& to) {
    return ZSTD_decompress(to.data(), to.size(), from.data(), from.size()) == to.size();
}

/// An error says what is wrong, but not in which file.
Result<std::string> unpack(ByteSource& file, const PackedChunk& chunk) {
    const auto& [compression, at, packed, size] = chunk;
    if (size > largest_chunk)
        return input_error("has a chunk of " + std::to_string(size >> 20) + " MiB: at most " +
                           std::to_string(largest_chunk >> 20) + " are read");
    // LZ4 cannot expand a byte to more; for bzip2 and zstd no recording comes near this limit. None makes
    // bytes many more either.
    constexpr std::uint64_t few = 4096;
    if (const std::uint32_t most = compression == "lz4" ? 255 : 4096;
        size / most > packed || packed > few + 2 * std::uint64_t{size})
        return input_error("is damaged: has a chunk of " + std::to_string(size) + " bytes in " +
                           std::to_string(packed));
    std::string stored(packed, '\0');
    TRY(file.read(at, stored.data(), stored.size()));
    if (compression.empty()) return stored;
    std::string bytes(size, '\0');
    const bool is_bz2 = compression == "bz2", is_zstd = compression == "zstd";
    if (is_bz2 ? unpack_bz2(stored, bytes) : is_zstd ? unpack_zstd(stored, bytes) : unpack_lz4(stored, bytes))
        return bytes;
    return input_error(std::string("is damaged: a chunk cannot be unpacked by ") + (is_bz2    ? "bzip2"
                                                                                    : is_zstd ? "zstd"
                                                                                              : "LZ4"));
}

/// Kinds of records in a recording of ROS 1.
enum class BagOp : std::uint8_t { message = 2, bag_header, index, chunk, chunk_info, connection };

constexpr std::uint32_t longest_header = 1 << 20;  // bytes; topics' names may be long

Error at_byte(std::uint64_t at, const std::string& what) {
    return input_error("is damaged: the record at byte " + std::to_string(at) + " " + what);
}

/// Fields "name=value" of a record, whose values are bytes.
class BagFields {
public:
    /// Nothing if the fields do not fill the bytes.
    static std::optional<BagFields> of(std::string bytes) {
        for (RosFields each(bytes); each.left() > 0;)
            if (each.text().find('=') == std::string_view::npos) return {};
        BagFields fields;
        fields.bytes_ = std::move(bytes);
        return fields;
    }

    std::optional<std::string_view> text(std::string_view name) const {
        for (RosFields each(bytes_); each.left() > 0;) {
            const std::string_view field = each.text();
            if (field.size() > name.size() && field[name.size()] == '=' && field.starts_with(name))
                return field.substr(name.size() + 1);
        }
        return {};
    }

    /// An unsigned number, low byte first, of exactly its type's size.
    template <class Number>
    std::optional<Number> number(std::string_view name) const {
        const auto value = text(name);
        if (!value || value->size() != sizeof(Number)) return {};
        return static_cast<Number>(number_in_bytes(*value, false));
    }

private:
    std::string bytes_;
};

/// A record's fields, and where its data are.
struct BagRecord {
    BagFields fields;
    std::uint64_t data_at = 0;
    std::uint32_t size = 0;  ///< of its data

    std::uint64_t end() const { return data_at + size; }
    bool is(BagOp op) const { return fields.number<std::uint8_t>("op") == static_cast<std::uint8_t>(op); }
};

/// The record that begins at `at` and ends by `end`. An error says what is wrong, but not in which file.
Result<BagRecord> read_bag_record(ByteSource& bytes, std::uint64_t at, std::uint64_t end) {
    const auto length_at = [&](std::uint64_t from) -> Result<std::uint32_t> {
        std::uint32_t length = 0;
        if (from > end || end - from < sizeof length) return at_byte(at, "is cut");
        TRY(bytes.read(from, reinterpret_cast<char*>(&length), sizeof length));
        return length;
    };
    TRY_ASSIGN(const auto header, length_at(at));
    std::uint64_t next = at + sizeof header;
    if (header > end - next || header > longest_header) return at_byte(at, "has a wrong length");
    std::string text(header, '\0');
    TRY(bytes.read(next, text.data(), text.size()));
    next += header;
    auto fields = BagFields::of(std::move(text));
    if (!fields) return at_byte(at, "has fields of wrong lengths");
    TRY_ASSIGN(const auto size, length_at(next));
    next += sizeof size;
    if (size > end - next) return at_byte(at, "is cut");
    return BagRecord{std::move(*fields), next, size};
}

constexpr std::string_view bag_magic = "#ROSBAG V";
constexpr std::string_view bag_version = "2.0\n";
constexpr std::uint32_t largest_definition = 4 << 20;  // of a message type, bytes
constexpr std::uint32_t index_entry = 12;              // bytes: seconds, nanoseconds, offset

class RosBag final : public BagFile {
public:
    explicit RosBag(std::string name) : BagFile(std::move(name)) {}

    Result<void> open(const SourceFile& file) {
        TRY_ASSIGN(bytes_, bytes_of_file(file));
        std::string begin(bag_magic.size() + bag_version.size(), '\0');
        if (bytes_->size() < begin.size()) return damaged("it ends in its first bytes");
        TRY(read_bytes(*bytes_, 0, begin.data(), begin.size()));
        if (!begin.ends_with(bag_version))
            return input_error(name() + ": is a recording of ROS 1 of version " +
                               printable(std::string_view(begin).substr(bag_magic.size())) +
                               ": must be of version 2.0 (rosbag fix makes one of an older one)");
        return read_index();
    }

    Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) override {
        std::vector<BagMessage> found;
        for (std::uint32_t number = 0; number < chunks_.size(); ++number) {
            const auto& within = chunks_[number].connections;
            if (std::ranges::find_first_of(within, connections) == within.end()) continue;
            TRY(find_messages(number, connections, found));
            if (found.size() > bytes_->size() / index_entry) return damaged("its index repeats itself");
        }
        std::ranges::stable_sort(found, {}, &BagMessage::time_ns);
        return found;
    }

    Result<RosMessage> read(const BagMessage& message, std::size_t most) override {
        Chunk& chunk = chunks_[message.chunk];
        TRY(read_chunk(chunk));
        const bool is_plain = chunk.compression == "none";
        TRY_ASSIGN(const auto packed, is_plain ? Result<ByteSource*>(bytes_.get()) : unpacked(message.chunk));
        const std::uint64_t from = is_plain ? chunk.data_at : 0;
        TRY_ASSIGN(const auto record, record_at(*packed, from + message.offset, from + chunk.size));
        if (!record.is(BagOp::message) || record.fields.number<std::uint32_t>("conn") != message.connection)
            return damaged("the message at byte " + std::to_string(message.offset) +
                           " of the chunk at byte " + std::to_string(chunk.at) +
                           " is none of its connection");
        const std::size_t size = std::min<std::size_t>(record.size, most);
        if (size > largest_message) return too_large(size);
        std::string data(size, '\0');
        TRY(read_bytes(*packed, record.data_at, data.data(), data.size()));
        return RosMessage{std::move(data)};
    }

private:
    struct Chunk {
        std::uint64_t at = 0;
        std::vector<std::uint32_t> connections;  ///< that have messages in it
        // From the chunk's own record; read on first use.
        bool is_read = false;
        std::string compression;
        std::uint64_t data_at = 0;
        std::uint32_t packed = 0, size = 0;
    };

    Result<void> read_bytes(ByteSource& from, std::uint64_t at, char* to, std::size_t count) const {
        auto read = from.read(at, to, count);
        if (read) return read;
        return read.error().kind == ErrorKind::input ? damaged(read.error().message)
                                                     : error_at(name(), read.error());
    }

    Result<BagRecord> record_at(ByteSource& bytes, std::uint64_t at, std::uint64_t end) const {
        return error_at(name(), read_bag_record(bytes, at, end));
    }

    /// Reads connections and chunks from the index at the file's end.
    Result<void> read_index() {
        const std::uint64_t end = bytes_->size();
        TRY_ASSIGN(const auto header, record_at(*bytes_, bag_magic.size() + bag_version.size(), end));
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
                               ": has no index, as the recorder was stopped before it wrote one, or the file "
                               "is cut: rosbag reindex makes one");
        std::uint64_t at = *index;
        for (std::uint32_t n = 0; n < *connections; ++n) {
            TRY_ASSIGN(const auto record, record_at(*bytes_, at, end));
            const auto id = record.fields.number<std::uint32_t>("conn");
            const auto topic = record.fields.text("topic");
            if (!record.is(BagOp::connection) || !id || !topic || record.size > largest_definition)
                return damaged("connection " + std::to_string(n) + " of its index is none");
            std::string data(record.size, '\0');
            TRY(read_bytes(*bytes_, record.data_at, data.data(), data.size()));
            const auto fields = BagFields::of(std::move(data));
            if (!fields) return damaged("connection " + std::to_string(n) + " of its index says nothing");
            if (std::ranges::count(BagFile::connections(), *id, &BagConnection::id) > 0)
                return damaged("connection " + std::to_string(*id) + " is in its index twice");
            add_connection({*id, std::string(*topic), std::string(fields->text("type").value_or("")),
                            std::string(fields->text("md5sum").value_or(""))});
            at = record.end();
        }
        for (std::uint32_t n = 0; n < *chunks; ++n) {
            TRY_ASSIGN(const auto record, record_at(*bytes_, at, end));
            const auto chunk_at = record.fields.number<std::uint64_t>("chunk_pos");
            const auto count = record.fields.number<std::uint32_t>("count");
            if (!record.is(BagOp::chunk_info) || !chunk_at || !count || record.size != 8ULL * *count)
                return damaged("chunk " + std::to_string(n) + " of its index is none");
            std::vector<std::uint32_t> counts(2ULL * *count);  // connection, messages
            TRY(read_bytes(*bytes_, record.data_at, reinterpret_cast<char*>(counts.data()), record.size));
            Chunk chunk;
            chunk.at = *chunk_at;
            for (std::size_t k = 0; k < counts.size(); k += 2) chunk.connections.push_back(counts[k]);
            chunks_.push_back(std::move(chunk));
            at = record.end();
        }
        return {};
    }

    Result<void> read_chunk(Chunk& chunk) {
        if (chunk.is_read) return {};
        TRY_ASSIGN(const auto record, record_at(*bytes_, chunk.at, bytes_->size()));
        const auto compression = record.fields.text("compression");
        const auto size = record.fields.number<std::uint32_t>("size");
        if (!record.is(BagOp::chunk) || !compression || !size)
            return damaged("there is no chunk at byte " + std::to_string(chunk.at));
        if (*compression != "none" && *compression != "bz2" && *compression != "lz4")
            return input_error(name() + ": is packed by " + printable(*compression) +
                               ": must be plain, bz2 or lz4");
        if (*compression == "none" && *size != record.size)
            return damaged("the chunk at byte " + std::to_string(chunk.at) + " has a wrong size");
        chunk.compression = *compression;
        chunk.data_at = record.data_at;
        chunk.packed = record.size;
        chunk.size = *size;
        chunk.is_read = true;
        return {};
    }

    /// Adds messages by the index records that follow the chunk.
    Result<void> find_messages(std::uint32_t number, std::span<const std::uint32_t> connections,
                               std::vector<BagMessage>& found) {
        Chunk& chunk = chunks_[number];
        TRY(read_chunk(chunk));
        std::uint64_t at = chunk.data_at + chunk.packed;
        for (std::size_t n = 0; n < chunk.connections.size(); ++n) {
            TRY_ASSIGN(const auto record, record_at(*bytes_, at, bytes_->size()));
            const auto id = record.fields.number<std::uint32_t>("conn");
            if (!record.is(BagOp::index) || !id || record.size % index_entry != 0)
                return damaged("the chunk at byte " + std::to_string(chunk.at) + " has no index");
            at = record.end();
            if (std::ranges::find(connections, *id) == connections.end()) continue;
            std::vector<std::uint32_t> entries(record.size / 4);
            TRY(read_bytes(*bytes_, record.data_at, reinterpret_cast<char*>(entries.data()), record.size));
            for (std::size_t k = 0; k < entries.size(); k += 3)  // seconds, nanoseconds, offset
                found.push_back(
                    {std::int64_t{entries[k]} * 1'000'000'000 + entries[k + 1], *id, number, entries[k + 2]});
        }
        return {};
    }

    Result<ByteSource*> unpacked(std::uint32_t number) {
        if (const Error* const why = why_given_up(number)) return *why;
        const Chunk& chunk = chunks_[number];
        auto bytes =
            unpacked_chunk(number, *bytes_, {chunk.compression, chunk.data_at, chunk.packed, chunk.size});
        if (!bytes) return give_up_chunk(number, error_at(name(), bytes.error()));
        return bytes;
    }

    std::unique_ptr<ByteSource> bytes_;
    std::vector<Chunk> chunks_;
};

}  // namespace

Result<std::unique_ptr<BagFile>> BagFile::open(const SourceFile& file) {
    const std::string begin = first_bytes(file, 16);
    if (is_mcap(begin)) return open_mcap_file(file);
    if (is_sqlite(begin)) return open_db3_file(file);
    return opened_as<BagFile>(std::make_unique<RosBag>(file.string()), file);
}

Result<std::optional<RosMessage>> BagFile::read_first(std::span<const BagMessage> messages) {
    for (const BagMessage& each : messages) {
        auto bytes = read(each);
        if (bytes) return std::optional(std::move(*bytes));
        if (bytes.error().kind == ErrorKind::interrupted || !is_given_up(messages.front()))
            return bytes.error();
    }
    return std::optional<RosMessage>();
}

std::string BagFile::left_out() const {
    if (given_up_.empty()) return "";
    const bool is_one = given_up_.size() == 1;
    return (is_one ? "a chunk is" : std::to_string(given_up_.size()) + " chunks are") +
           std::string(" damaged, and what cannot be read of ") + (is_one ? "it" : "them") +
           " is left out: " + given_up_.begin()->second.message;
}

Result<ByteSource*> BagFile::unpacked_chunk(std::uint32_t number, ByteSource& file,
                                            const PackedChunk& chunk) {
    const auto there = std::ranges::find(unpacked_, number, &Unpacked::number);
    if (there != unpacked_.end()) return there->source.get();
    constexpr std::size_t kept = 2;
    while (unpacked_.size() >= kept) unpacked_.pop_front();
    TRY_ASSIGN(auto bytes, unpack(file, chunk));
    unpacked_.push_back({number, std::move(bytes), nullptr});
    unpacked_.back().source = bytes_in_memory(unpacked_.back().bytes);
    return unpacked_.back().source.get();
}

Error BagFile::too_large(std::uint64_t message_size) const {
    return input_error(name() + ": has a message of " + std::to_string(message_size >> 20) +
                       " MiB: at most " + std::to_string(largest_message >> 20) + " are read");
}

bool is_recording_of_ros(std::string_view begin) {
    return begin.starts_with(bag_magic) || is_mcap(begin) || is_sqlite(begin);
}

}  // namespace touchable
