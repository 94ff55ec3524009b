// SPDX-License-Identifier: Apache-2.0
// A database that reads nothing but the bytes it is given (SqliteBytes), and the recording in it.

#include "engine/formats/bag_file.hpp"

#include <sqlite3.h>

#include <cstring>
#include <functional>
#include <map>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/ros_messages.hpp"

namespace touchable {
namespace {

constexpr std::string_view sqlite_magic("SQLite format 3\0", 16);
constexpr int steps_at_once = 1000;

/// Limits what a hostile schema could make long.
void set_sqlite_limits(sqlite3* database) {
    constexpr int text_bytes = 1 << 20;
    const int limits[][2] = {{SQLITE_LIMIT_LENGTH, text_bytes}, {SQLITE_LIMIT_SQL_LENGTH, text_bytes},
                             {SQLITE_LIMIT_COLUMN, 64},         {SQLITE_LIMIT_EXPR_DEPTH, 16},
                             {SQLITE_LIMIT_COMPOUND_SELECT, 2}, {SQLITE_LIMIT_VDBE_OP, 10000},
                             {SQLITE_LIMIT_FUNCTION_ARG, 8},    {SQLITE_LIMIT_ATTACHED, 0},
                             {SQLITE_LIMIT_TRIGGER_DEPTH, 1},   {SQLITE_LIMIT_WORKER_THREADS, 0}};
    for (const auto& [which, most] : limits) sqlite3_limit(database, which, most);
    for (const int off : {SQLITE_DBCONFIG_TRUSTED_SCHEMA, SQLITE_DBCONFIG_ENABLE_VIEW,
                          SQLITE_DBCONFIG_ENABLE_TRIGGER, SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION})
        sqlite3_db_config(database, off, 0, nullptr);
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_drop_modules(database, nullptr);  // of virtual tables
}

/// Refuses a cut last page, which SQLite itself does not notice.
Result<void> check_pages(ByteSource& bytes) {
    constexpr std::uint64_t header = 100;
    unsigned char size[2]{};
    constexpr std::uint64_t size_at = 16;
    const bool is_whole = bytes.size() >= header;
    if (is_whole) TRY(bytes.read(size_at, reinterpret_cast<char*>(size), sizeof size));
    const std::uint64_t said = 256U * size[0] + size[1], page = said == 1 ? 65536 : said;
    if (!is_whole || page == 0 || bytes.size() % page != 0) return input_error("is damaged: it is cut");
    return {};
}

/// A SQLite database in bytes that may be hostile. No other file is opened (neither journal nor write-ahead
/// log), nothing is written, and views, virtual tables and extensions are off. Errors say what is wrong; the
/// caller puts the file's name and a colon before them.
class SqliteBytes : NonCopyable {
public:
    /// `bytes` must outlive the database.
    static Result<std::unique_ptr<SqliteBytes>> open(ByteSource& bytes) {
        TRY(check_pages(bytes));
        std::unique_ptr<SqliteBytes> opened(new SqliteBytes(bytes));
        opened->name_ = "touchable-" + std::to_string(reinterpret_cast<std::uintptr_t>(opened.get()));
        opened->system_ = file_system(*opened);
        if (sqlite3_vfs_register(&opened->system_, 0) != SQLITE_OK) return opened->failed();
        const int status = sqlite3_open_v2("bytes", &opened->database_,
                                           SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, opened->name_.c_str());
        sqlite3_vfs_unregister(&opened->system_);
        if (status != SQLITE_OK) return opened->failed();
        set_sqlite_limits(opened->database_);
        sqlite3_progress_handler(opened->database_, steps_at_once, is_enough, opened.get());
        for (const char* statement : {"PRAGMA temp_store=MEMORY", "PRAGMA cell_size_check=ON"})
            TRY(opened->each_row(statement, [](sqlite3_stmt&) { return Result<void>{}; }));
        return opened;
    }

    ~SqliteBytes() {
        sqlite3_blob_close(blob_);
        sqlite3_close(database_);
    }

    /// Calls `row` for every row of the statement's result, until `row` fails. A statement that takes too
    /// many steps for the database's size is refused.
    Result<void> each_row(const char* statement, const std::function<Result<void>(sqlite3_stmt&)>& row) {
        steps_ = 0;
        sqlite3_stmt* prepared = nullptr;
        const int status = sqlite3_prepare_v2(database_, statement, -1, &prepared, nullptr);
        const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> closer(prepared, sqlite3_finalize);
        if (status != SQLITE_OK) return failed();
        for (;;) {
            const int step = sqlite3_step(prepared);
            if (step == SQLITE_DONE) return {};
            if (step != SQLITE_ROW) return failed();
            TRY(row(*prepared));
        }
    }

    /// find_blob returns a blob's size, read_blob then its first bytes; one blob at a time.
    Result<std::uint64_t> find_blob(const char* table, const char* column, std::int64_t row) {
        steps_ = 0;
        const int status = blob_ != nullptr
                               ? sqlite3_blob_reopen(blob_, row)
                               : sqlite3_blob_open(database_, "main", table, column, row, 0, &blob_);
        if (status == SQLITE_OK) return static_cast<std::uint64_t>(sqlite3_blob_bytes(blob_));
        Error why = failed();
        sqlite3_blob_close(blob_);
        blob_ = nullptr;
        return why;
    }

    Result<std::string> read_blob(std::size_t count) {
        std::string value(count, '\0');
        if (sqlite3_blob_read(blob_, value.data(), static_cast<int>(count), 0) != SQLITE_OK) return failed();
        return value;
    }

private:
    /// What SQLite keeps of an open file.
    struct OpenBytes {
        sqlite3_file file;
        SqliteBytes* of;
    };

    explicit SqliteBytes(ByteSource& bytes) : bytes_(bytes) {}
    static SqliteBytes* owner_of(sqlite3_file* file) { return reinterpret_cast<OpenBytes*>(file)->of; }
    Error failed() {
        if (unread_) {
            Error why = std::move(*unread_);
            unread_.reset();
            return why;
        }
        if (stop_requested()) return interrupted_error();
        const int status = database_ != nullptr ? sqlite3_errcode(database_) : SQLITE_NOMEM;
        if (status == SQLITE_NOMEM) return internal_error("SQLite is out of memory");
        if (status == SQLITE_INTERRUPT) return input_error("is damaged: SQLite did not finish reading it");
        return input_error((status == SQLITE_ERROR ? "is not as ROS 2 writes it" : "is damaged") +
                           std::string(", as SQLite says: ") + printable(sqlite3_errmsg(database_), 100));
    }

    /// A file system in which these bytes are the only file.
    static sqlite3_vfs file_system(SqliteBytes& of) {
        sqlite3_vfs system{};
        system.iVersion = 1;
        system.szOsFile = sizeof(OpenBytes);
        system.mxPathname = 64;
        system.zName = of.name_.c_str();
        system.pAppData = &of;
        system.xOpen = open_file;
        system.xDelete = [](sqlite3_vfs*, const char*, int) { return SQLITE_READONLY; };
        system.xAccess = [](sqlite3_vfs*, const char*, int, int* is_there) { return *is_there = 0; };
        system.xFullPathname = [](sqlite3_vfs*, const char* name, int size, char* to) {
            sqlite3_snprintf(size, to, "%s", name);
            return SQLITE_OK;
        };
        system.xRandomness = [](sqlite3_vfs*, int size, char* to) {
            std::memset(to, 0, static_cast<std::size_t>(size));
            return size;
        };
        system.xSleep = [](sqlite3_vfs*, int) { return 0; };
        system.xCurrentTime = [](sqlite3_vfs*, double* day) {
            *day = 0;
            return SQLITE_OK;
        };
        system.xGetLastError = [](sqlite3_vfs*, int, char*) { return 0; };
        return system;
    }

    static int open_file(sqlite3_vfs* system, const char* /*name*/, sqlite3_file* file, int flags,
                         int* given) {
        file->pMethods = nullptr;
        if ((flags & SQLITE_OPEN_MAIN_DB) == 0) return SQLITE_CANTOPEN;
        static const sqlite3_io_methods methods = [] {
            sqlite3_io_methods all{};
            all.iVersion = 1;
            all.xClose = [](sqlite3_file*) { return SQLITE_OK; };
            all.xRead = read_file;
            all.xWrite = [](sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; };
            all.xTruncate = [](sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; };
            all.xSync = [](sqlite3_file*, int) { return SQLITE_OK; };
            all.xFileSize = tell_size;
            all.xLock = [](sqlite3_file*, int) { return SQLITE_OK; };
            all.xUnlock = [](sqlite3_file*, int) { return SQLITE_OK; };
            all.xCheckReservedLock = [](sqlite3_file*, int* is_locked) { return *is_locked = 0; };
            all.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
            all.xSectorSize = [](sqlite3_file*) { return 4096; };
            all.xDeviceCharacteristics = [](sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; };
            return all;
        }();
        reinterpret_cast<OpenBytes*>(file)->of = static_cast<SqliteBytes*>(system->pAppData);
        file->pMethods = &methods;
        if (given != nullptr) *given = SQLITE_OPEN_READONLY;
        return SQLITE_OK;
    }

    /// Bytes behind the end read as zeros.
    static int read_file(sqlite3_file* file, void* to, int count, sqlite3_int64 at) {
        SqliteBytes& self = *owner_of(file);
        const auto from = static_cast<std::uint64_t>(at), wanted = static_cast<std::uint64_t>(count),
                   size = self.bytes_.size();
        const std::uint64_t there = from < size ? std::min(wanted, size - from) : 0;
        std::memset(to, 0, static_cast<std::size_t>(count));
        if (there > 0)
            if (auto read = self.bytes_.read(from, static_cast<char*>(to), static_cast<std::size_t>(there));
                !read) {
                self.unread_ = read.error();
                return SQLITE_IOERR_READ;
            }
        return there == wanted ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
    }

    static int tell_size(sqlite3_file* file, sqlite3_int64* size) {
        *size = static_cast<sqlite3_int64>(owner_of(file)->bytes_.size());
        return SQLITE_OK;
    }

    static int is_enough(void* database) {
        SqliteBytes& self = *static_cast<SqliteBytes*>(database);
        constexpr std::uint64_t least = 10'000;  // thousands of steps; a tenth of a second
        return ++self.steps_ > least + self.bytes_.size() / (2 * steps_at_once) || stop_requested() ? 1 : 0;
    }

    ByteSource& bytes_;
    std::string name_;  // unique among SQLite's file systems
    sqlite3_vfs system_{};
    sqlite3* database_ = nullptr;
    sqlite3_blob* blob_ = nullptr;
    std::optional<Error> unread_;  // why the bytes could not be read
    std::uint64_t steps_ = 0;      // of the statement, thousands
};

std::string column_text(sqlite3_stmt& row, int column) {
    const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(&row, column));
    return text == nullptr ? ""
                           : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(&row, column)));
}

class Db3File final : public BagFile {
public:
    explicit Db3File(std::string name) : BagFile(std::move(name)) {}

    Result<void> open(const SourceFile& file) {
        TRY_ASSIGN(bytes_, bytes_of_file(file));
        TRY_ASSIGN(database_, error_at(name(), SqliteBytes::open(*bytes_)));
        TRY(check_tables());
        TRY(add_topics());
        TRY(find_messages());
        std::error_code failure;
        const std::filesystem::path log = file.path().string() + "-wal";
        if (const auto size = std::filesystem::file_size(log, failure); !failure && size > 0)
            left_out_ = "the messages in " + log.filename().string() +
                        " are left out, as the recorder was stopped before it put them into the recording";
        return {};
    }

    Result<std::vector<BagMessage>> messages(std::span<const std::uint32_t> connections) override {
        std::vector<BagMessage> some;
        for (const BagMessage& each : found_)
            if (std::ranges::find(connections, each.connection) != connections.end()) some.push_back(each);
        std::ranges::stable_sort(some, {}, &BagMessage::time_ns);
        return some;
    }

    Result<RosMessage> read(const BagMessage& message, std::size_t most) override {
        const auto row = static_cast<std::int64_t>(message.offset);
        TRY_ASSIGN(auto size, error_at(name(), database_->find_blob("messages", "data", row)));
        if (size > bytes_->size()) return damaged("a message is longer than the file");
        size = std::min<std::uint64_t>(size, most);
        if (size > largest_message) return too_large(size);
        TRY_ASSIGN(auto data, error_at(name(), database_->read_blob(static_cast<std::size_t>(size))));
        if (data.starts_with("\x28\xb5\x2f\xfd"))
            return input_error(name() +
                               ": its messages are packed by zstd (compression_mode: message), which is not "
                               "read: ros2 bag convert makes a plain recording of it");
        return RosMessage{std::move(data), true};
    }

    std::string left_out() const override { return left_out_; }

private:
    /// Checks that a recording's tables exist and that all their columns are stored.
    Result<void> check_tables() {
        int tables = 0, computed = 0;
        auto counted = database_->each_row(
            "SELECT 1 FROM sqlite_schema WHERE type='table' AND rootpage>0 AND name IN ('topics','messages')",
            [&](sqlite3_stmt&) -> Result<void> {
                ++tables;
                return {};
            });
        constexpr int hidden = 6;  // column of the result
        for (const char* columns : {"PRAGMA table_xinfo(topics)", "PRAGMA table_xinfo(messages)"})
            if (counted)
                counted = database_->each_row(columns, [&](sqlite3_stmt& row) -> Result<void> {
                    computed += sqlite3_column_int(&row, hidden) != 0;
                    return {};
                });
        TRY(error_at(name(), std::move(counted)));
        if (tables == 2 && computed == 0) return {};
        return input_error(
            name() +
            ": is a database of SQLite, but no recording of ROS 2: must have the tables topics and messages");
    }

    /// Adds the topics; other types and encodings are left out.
    Result<void> add_topics() {
        auto added = database_->each_row(
            "SELECT id, name, type, serialization_format FROM topics",
            [this](sqlite3_stmt& row) -> Result<void> {
                const auto type = ros2_type(column_text(row, 2));
                if (!type || column_text(row, 3) != "cdr") return {};
                const auto id = static_cast<std::uint32_t>(topics_.size());
                if (!topics_.emplace(sqlite3_column_int64(&row, 0), id).second) return {};
                add_connection({id, column_text(row, 1), std::string(type->name), std::string(type->md5)});
                return {};
            });
        return error_at(name(), std::move(added));
    }

    /// Adds all messages. Rows must ascend by number: those of a damaged table may never end.
    Result<void> find_messages() {
        std::optional<std::int64_t> last;
        auto found = database_->each_row(
            "SELECT rowid, topic_id, timestamp FROM messages NOT INDEXED",
            [&](sqlite3_stmt& row) -> Result<void> {
                const std::int64_t number = sqlite3_column_int64(&row, 0);
                if (last && number <= *last) return input_error("is damaged: its messages are not in order");
                last = number;
                const auto topic = topics_.find(sqlite3_column_int64(&row, 1));
                if (topic == topics_.end()) return {};
                constexpr std::uint64_t least = 32;  // bytes of a message
                if (found_.size() > bytes_->size() / least)
                    return input_error("is damaged: has more messages than bytes for them");
                found_.push_back(
                    {sqlite3_column_int64(&row, 2), topic->second, 0, static_cast<std::uint64_t>(number)});
                return {};
            });
        return error_at(name(), std::move(found));
    }

    std::unique_ptr<ByteSource> bytes_;
    std::unique_ptr<SqliteBytes> database_;
    std::map<std::int64_t, std::uint32_t> topics_;  // the topics' connections
    std::vector<BagMessage> found_;                 // `offset`: the row
    std::string left_out_;
};

}  // namespace

bool is_sqlite(std::string_view begin) {
    return begin.starts_with(sqlite_magic);
}

Result<std::unique_ptr<BagFile>> open_db3_file(const SourceFile& file) {
    return opened_as<BagFile>(std::make_unique<Db3File>(file.string()), file);
}

}  // namespace touchable
