#include "engine/formats/db3_file.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/formats/cdr_message.hpp"
#include "engine/formats/sqlite_bytes.hpp"

namespace touchable {
namespace {

class Db3File final : public BagFile {
public:
    explicit Db3File(std::string name) : BagFile(std::move(name)) {}
    Result<void> open(const SourceFile& file);
    Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) override;
    Result<std::string> read(const BagMessage& message, std::size_t most) override;
    std::string left_out() const override { return left_out_; }

private:
    Result<void> check_tables();
    Result<void> add_topics();
    Result<void> find_messages();
    Error at_file(const Error& why) const { return error_at(name(), why); }

    std::unique_ptr<ByteSource> bytes_;
    std::unique_ptr<SqliteBytes> database_;
    std::vector<RosType> types_;                    // of each connection
    std::map<std::int64_t, std::uint32_t> topics_;  // their connections
    std::vector<BagMessage> found_;                 // `offset`: the row
    std::string left_out_;
};

std::string text_of(sqlite3_stmt& row, int column) {
    const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(&row, column));
    return text == nullptr ? ""
                           : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(&row, column)));
}

Result<void> Db3File::open(const SourceFile& file) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    bytes_ = std::move(bytes);
    auto database = SqliteBytes::open(*bytes_);
    if (!database) return at_file(database.error());
    database_ = std::move(*database);
    if (auto checked = check_tables(); !checked) return checked;
    if (auto added = add_topics(); !added) return added;
    if (auto found = find_messages(); !found) return found;
    std::error_code failure;
    const std::filesystem::path log = file.path().string() + "-wal";
    if (const auto size = std::filesystem::file_size(log, failure); !failure && size > 0)
        left_out_ = "the messages in " + log.filename().string() +
                    " are left out, as the recorder was stopped before it put them into the recording";
    return {};
}

/// Those of a recording, as tables of which every column is stored.
Result<void> Db3File::check_tables() {
    int tables = 0, computed = 0;
    auto counted = database_->each_row(
        "SELECT 1 FROM sqlite_schema WHERE type='table' AND rootpage>0 AND name IN ('topics','messages')",
        [&](sqlite3_stmt&) -> Result<void> {
            ++tables;
            return {};
        });
    constexpr int hidden = 6;  // column of the answer
    for (const char* columns : {"PRAGMA table_xinfo(topics)", "PRAGMA table_xinfo(messages)"})
        if (counted)
            counted = database_->each_row(columns, [&](sqlite3_stmt& row) -> Result<void> {
                computed += sqlite3_column_int(&row, hidden) != 0;
                return {};
            });
    if (!counted) return at_file(counted.error());
    if (tables == 2 && computed == 0) return {};
    return input_error(
        name() +
        ": is a database of SQLite, but no recording of ROS 2: must have the tables topics and "
        "messages");
}

/// Those that nothing here reads are left out.
Result<void> Db3File::add_topics() {
    const auto added = database_->each_row(
        "SELECT id, name, type, serialization_format FROM topics", [this](sqlite3_stmt& row) -> Result<void> {
            const auto type = ros2_type(text_of(row, 2));
            if (!type || text_of(row, 3) != "cdr") return {};
            const auto id = static_cast<std::uint32_t>(types_.size());
            if (!topics_.emplace(sqlite3_column_int64(&row, 0), id).second) return {};
            types_.push_back(*type);
            add_connection({id, text_of(row, 1), std::string(type->name), std::string(type->md5)});
            return {};
        });
    return added ? added : at_file(added.error());
}

/// A table gives its rows by their numbers: what does not ends nowhere.
Result<void> Db3File::find_messages() {
    std::optional<std::int64_t> last;
    const auto found =
        database_->each_row("SELECT rowid, topic_id, timestamp FROM messages NOT INDEXED",
                            [&](sqlite3_stmt& row) -> Result<void> {
                                const std::int64_t number = sqlite3_column_int64(&row, 0);
                                if (last && number <= *last)
                                    return input_error("is damaged: its messages are not in order");
                                last = number;
                                const auto topic = topics_.find(sqlite3_column_int64(&row, 1));
                                if (topic == topics_.end()) return {};
                                constexpr std::uint64_t least = 32;  // bytes of a message that is read
                                if (found_.size() > bytes_->size() / least)
                                    return input_error("is damaged: has more messages than bytes for them");
                                found_.push_back({sqlite3_column_int64(&row, 2), topic->second, 0,
                                                  static_cast<std::uint64_t>(number)});
                                return {};
                            });
    return found ? found : at_file(found.error());
}

Result<std::vector<BagMessage>> Db3File::messages(std::span<const std::uint32_t> connections) {
    std::vector<BagMessage> some;
    for (const BagMessage& each : found_)
        if (std::find(connections.begin(), connections.end(), each.connection) != connections.end())
            some.push_back(each);
    std::stable_sort(some.begin(), some.end(),
                     [](const BagMessage& a, const BagMessage& b) { return a.time_ns < b.time_ns; });
    return some;
}

Result<std::string> Db3File::read(const BagMessage& message, std::size_t most) {
    auto size = database_->find_blob("messages", "data", static_cast<std::int64_t>(message.offset));
    if (!size) return at_file(size.error());
    if (*size > bytes_->size()) return damaged("a message is longer than the file");
    if (most <= ros_stamp_bytes) *size = std::min<std::uint64_t>(*size, cdr_stamp_bytes);
    if (*size > largest_message) return too_large(*size);
    const auto data = database_->read_blob(static_cast<std::size_t>(*size));
    if (!data) return at_file(data.error());
    if (data->starts_with("\x28\xb5\x2f\xfd"))
        return input_error(
            name() +
            ": its messages are packed by zstd (compression_mode: message), which is not read: "
            "ros2 bag convert makes a plain recording of it");
    return ros1_of_cdr(*data, types_[message.connection]);
}

}  // namespace

Result<std::unique_ptr<BagFile>> open_db3_file(const SourceFile& file) {
    auto opened = std::make_unique<Db3File>(file.string());
    TRY(opened->open(file));
    return std::unique_ptr<BagFile>(std::move(opened));
}

}  // namespace touchable
