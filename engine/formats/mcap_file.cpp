// SPDX-License-Identifier: Apache-2.0
// Recordings in MCAP: reads records in the file and in its chunks, by the chunks' indices if these are right.

#include "engine/formats/bag_file.hpp"

#include <map>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::string_view mcap_magic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t record_head = 9;  // kind, length
constexpr std::size_t message_head = 22;  // channel, sequence, when logged, when published
constexpr std::size_t index_pair = 16;    // time, offset
constexpr std::uint64_t longest_text = 1 << 16;
constexpr std::size_t pairs_at_once = 4096;
constexpr std::uint32_t outside = 0xffffffff;  // a message in no chunk

enum class McapOp : std::uint8_t { schema = 3, channel = 4, message = 5, chunk = 6, index = 7 };

class McapFile final : public BagFile {
public:
    explicit McapFile(std::string name) : BagFile(std::move(name)) {}

    Result<void> open(const SourceFile& file) {
        TRY_ASSIGN(bytes_, bytes_of_file(file));
        TRY(records(*bytes_, outside));
        const bool tells_channels = !is_cdr_.empty();  // in its summary
        for (std::uint32_t number = 0; number < chunks_.size(); ++number) {
            if (stop_requested()) return interrupted_error();
            if (tells_channels && !chunks_[number].indices.empty()) continue;
            TRY(look_into(number));
        }
        return {};
    }

    Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) override {
        std::vector<BagMessage> all;
        const auto add = [&](const std::vector<BagMessage>& some) {
            for (const BagMessage& each : some)
                if (std::ranges::count(connections, each.connection) > 0) all.push_back(each);
        };
        add(loose_);
        for (std::uint32_t number = 0; number < chunks_.size(); ++number) {
            if (chunks_[number].is_lost) continue;
            const std::size_t before = all.size();
            TRY_ASSIGN(const auto told, read_indices(number, connections, all));
            if (!told) {
                all.resize(before);
                chunks_[number].indices.clear();
                TRY(look_into(number));
            }
            add(chunks_[number].found);
        }
        std::ranges::stable_sort(all, {}, &BagMessage::time_ns);
        return all;
    }

    Result<RosMessage> read(const BagMessage& message, std::size_t most) override {
        const bool is_loose = message.chunk == outside;
        TRY_ASSIGN(const auto bytes, is_loose || chunks_[message.chunk].compression.empty()
                                         ? Result<ByteSource*>(bytes_.get())
                                         : contents(message.chunk));
        const bool is_in_file = bytes == bytes_.get();
        const McapChunk* const chunk = is_loose ? nullptr : &chunks_[message.chunk];
        const std::uint64_t first = is_in_file && chunk ? chunk->at : 0;
        const std::uint64_t end = is_in_file && chunk ? chunk->at + chunk->packed : bytes->size();
        const auto none = [&] {
            return give_up_chunk(message.chunk,
                                 damaged("a message that its index names is none of its channel"));
        };
        constexpr std::uint64_t heads = record_head + message_head;
        if (message.offset > end - first || end - first - message.offset < heads) return none();
        std::string head(heads, '\0');
        const std::uint64_t at = first + message.offset;
        TRY(read_bytes(*bytes, at, head.data(), head.size()));
        RosFields fields(head);
        const auto op = static_cast<McapOp>(fields.number<std::uint8_t>());
        const auto length = fields.number<std::uint64_t>();
        const auto channel = fields.number<std::uint16_t>();
        if (op != McapOp::message || channel != message.connection || length < message_head ||
            length > end - at - record_head)
            return none();
        const std::uint64_t size = std::min<std::uint64_t>(length - message_head, most);
        if (size > largest_message) return too_large(size);
        std::string data(static_cast<std::size_t>(size), '\0');
        TRY(read_bytes(*bytes, at + heads, data.data(), data.size()));
        return RosMessage{std::move(data), is_cdr_.at(channel)};
    }

private:
    struct Index {
        std::uint16_t channel;
        std::uint64_t at, pairs;
    };
    struct McapChunk {
        std::uint64_t at = 0, packed = 0, size = 0;
        std::string compression;
        std::vector<Index> indices{};
        bool has_wrong_index = false, is_lost = false;
        std::vector<BagMessage> found{};  // if it has no valid index
    };

    Result<void> read_bytes(ByteSource& from, std::uint64_t at, char* to, std::size_t count) const {
        return error_at(name(), from.read(at, to, count));
    }

    /// Reads the records of the file or of an unpacked chunk, up to one that is cut.
    Result<void> records(ByteSource& bytes, std::uint32_t chunk) {
        const std::uint64_t end = bytes.size();
        for (std::uint64_t at = chunk == outside ? mcap_magic.size() : 0; at + record_head <= end;) {
            std::string head(record_head, '\0');
            TRY(read_bytes(bytes, at, head.data(), head.size()));
            RosFields fields(head);
            const auto op = static_cast<McapOp>(fields.number<std::uint8_t>());
            const auto length = fields.number<std::uint64_t>();
            constexpr McapOp none{};  // what was never written, such as a hole in a file
            if (op == none || length > end - at - record_head) return {};
            TRY(record(bytes, op, at + record_head, length, chunk));
            at += record_head + length;
        }
        return {};
    }

    Result<void> record(ByteSource& bytes, McapOp op, std::uint64_t at, std::uint64_t length,
                        std::uint32_t chunk) {
        const bool is_wanted = op == McapOp::schema || op == McapOp::channel || op == McapOp::message ||
                               (chunk == outside && (op == McapOp::chunk || op == McapOp::index));
        if (!is_wanted) return {};
        const std::uint64_t needed = op == McapOp::message ? message_head : longest_text;
        std::string head(static_cast<std::size_t>(std::min(length, needed)), '\0');
        TRY(read_bytes(bytes, at, head.data(), head.size()));
        RosFields fields(head);
        if (op == McapOp::schema) add_schema(fields);
        if (op == McapOp::channel) add_channel(fields);
        if (op == McapOp::chunk) return add_chunk(head, at, length);
        if (op == McapOp::index && !chunks_.empty()) add_index(fields, at, length);
        if (op == McapOp::message && length >= message_head) {
            const auto channel = fields.number<std::uint16_t>();
            fields.number<std::uint32_t>();
            const auto time = static_cast<std::int64_t>(fields.number<std::uint64_t>());
            if (!is_cdr_.contains(channel)) return {};  // a channel precedes its messages
            auto& found = chunk == outside ? loose_ : chunks_[chunk].found;
            found.push_back({time, channel, chunk, at - record_head});
        }
        return {};
    }

    Result<void> add_chunk(const std::string& head, std::uint64_t at, std::uint64_t length) {
        RosFields fields(head);
        fields.number<std::uint64_t>();
        fields.number<std::uint64_t>();
        McapChunk chunk;
        chunk.size = fields.number<std::uint64_t>();
        fields.number<std::uint32_t>();
        chunk.compression = fields.text();
        chunk.packed = fields.number<std::uint64_t>();
        chunk.at = at + (head.size() - fields.left());
        constexpr std::uint64_t most = 0xffffffff;
        std::optional<Error> wrong;
        if (!fields.ok() || chunk.packed > at + length - chunk.at ||
            (chunk.compression.empty() && chunk.size != chunk.packed))
            wrong = damaged("the chunk at byte " + std::to_string(at) + " is none");
        else if (chunk.packed > most || chunk.size > most)
            wrong = damaged("a chunk is larger than 4 GiB");
        else if (!chunk.compression.empty() && chunk.compression != "lz4" && chunk.compression != "zstd")
            return input_error(name() + ": is packed by " + printable(chunk.compression) +
                               ": must be plain, lz4 or zstd");
        chunks_.push_back(std::move(chunk));
        if (wrong) (void)lose(static_cast<std::uint32_t>(chunks_.size() - 1), *wrong);
        return {};
    }

    /// Adds an index of the newest chunk. If it is invalid, the chunk is searched instead.
    void add_index(RosFields fields, std::uint64_t at, std::uint64_t length) {
        McapChunk& chunk = chunks_.back();
        const auto channel = fields.number<std::uint16_t>();
        const auto size = fields.number<std::uint32_t>();
        constexpr std::uint64_t begins = sizeof channel + sizeof size;
        if (!fields.ok() || size > length - begins || size % index_pair != 0 ||
            size / index_pair > chunk.size / (record_head + message_head))
            chunk.has_wrong_index = true;
        if (chunk.has_wrong_index)
            chunk.indices.clear();
        else
            chunk.indices.push_back({channel, at + begins, size / index_pair});
    }

    void add_schema(RosFields fields) {
        const auto id = fields.number<std::uint16_t>();
        const auto type = ros2_type(std::string(fields.text()));
        if (fields.ok() && type) schemas_.emplace(id, *type);
    }

    /// Adds a channel; other types and encodings are left out.
    void add_channel(RosFields fields) {
        const auto id = fields.number<std::uint16_t>(), schema = fields.number<std::uint16_t>();
        const std::string topic(fields.text()), encoding(fields.text());
        const auto type = schemas_.find(schema);
        if (!fields.ok() || type == schemas_.end() || (encoding != "cdr" && encoding != "ros1")) return;
        const RosType& known = type->second;
        if (is_cdr_.emplace(id, encoding == "cdr").second)
            add_connection({id, topic, std::string(known.name), std::string(known.md5)});
    }

    /// Gives up a chunk as a whole.
    Error lose(std::uint32_t number, const Error& why) {
        chunks_[number].is_lost = why.kind == ErrorKind::input;
        return give_up_chunk(number, why);
    }

    /// Searches a chunk for channels, and for messages if it has no index; gives up one that cannot be
    /// unpacked.
    Result<void> look_into(std::uint32_t number) {
        const auto bytes = contents(number);
        if (!bytes) return chunks_[number].is_lost ? Result<void>{} : bytes.error();
        TRY(records(**bytes, number));
        if (!chunks_[number].indices.empty()) chunks_[number].found = {};
        return {};
    }

    Result<ByteSource*> contents(std::uint32_t number) {
        const McapChunk& chunk = chunks_[number];
        if (chunk.is_lost) return *why_given_up(number);
        auto bytes = unpacked_chunk(number, *bytes_,
                                    {chunk.compression, chunk.at, static_cast<std::uint32_t>(chunk.packed),
                                     static_cast<std::uint32_t>(chunk.size)});
        if (!bytes)
            return lose(number,
                        error_at(name() + ": the chunk at byte " + std::to_string(chunk.at), bytes.error()));
        return bytes;
    }

    /// Adds the messages of these channels by a chunk's indices; false if an index is wrong. An index as long
    /// as a hole in a file is detected before it is kept: no two messages have the same offset.
    Result<bool> read_indices(std::uint32_t number, std::span<const std::uint32_t> channels,
                              std::vector<BagMessage>& found) {
        const McapChunk& chunk = chunks_[number];
        std::vector<std::uint64_t> pairs;
        for (const Index& index : chunk.indices) {
            if (std::ranges::find(channels, index.channel) == channels.end()) continue;
            std::uint64_t last = chunk.size;
            for (std::uint64_t at = 0; at < index.pairs; at += pairs.size() / 2) {
                pairs.resize(
                    2 * static_cast<std::size_t>(std::min<std::uint64_t>(index.pairs - at, pairs_at_once)));
                TRY(read_bytes(*bytes_, index.at + index_pair * at, reinterpret_cast<char*>(pairs.data()),
                               sizeof pairs[0] * pairs.size()));
                for (std::size_t k = 0; k < pairs.size(); k += 2) {
                    if (pairs[k + 1] >= chunk.size || pairs[k + 1] == last) return false;
                    last = pairs[k + 1];
                    found.push_back({static_cast<std::int64_t>(pairs[k]), index.channel, number, last});
                }
            }
        }
        return true;
    }

    std::unique_ptr<ByteSource> bytes_;
    std::vector<McapChunk> chunks_;
    std::vector<BagMessage> loose_;  // in no chunk
    std::map<std::uint16_t, RosType> schemas_;
    std::map<std::uint16_t, bool> is_cdr_;  // the messages of each channel; otherwise of ROS 1
};

}  // namespace

bool is_mcap(std::string_view begin) {
    return begin.starts_with(mcap_magic);
}

Result<std::unique_ptr<BagFile>> open_mcap_file(const SourceFile& file) {
    return opened_as<BagFile>(std::make_unique<McapFile>(file.string()), file);
}

}  // namespace touchable
