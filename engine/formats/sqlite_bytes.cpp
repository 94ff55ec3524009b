#include "engine/formats/sqlite_bytes.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <string_view>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::string_view sqlite_magic("SQLite format 3\0", 16);
constexpr int steps_at_once = 1000;

/// What SQLite keeps of an open file.
struct OpenBytes {
    sqlite3_file file;
    SqliteBytes* of;
};

SqliteBytes* owner_of(sqlite3_file* file) {
    return reinterpret_cast<OpenBytes*>(file)->of;
}

/// What a hostile schema may make long is short.
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

/// SQLite itself does not miss what is cut from the last page.
Result<void> check_pages(ByteSource& bytes) {
    constexpr std::uint64_t header = 100;
    unsigned char size[2]{};
    constexpr std::uint64_t size_at = 16;
    const bool is_whole = bytes.size() >= header;
    if (is_whole)
        if (auto read = bytes.read(size_at, reinterpret_cast<char*>(size), sizeof size); !read) return read;
    const std::uint64_t said = 256U * size[0] + size[1], page = said == 1 ? 65536 : said;
    if (!is_whole || page == 0 || bytes.size() % page != 0) return input_error("is damaged: it is cut");
    return {};
}

}  // namespace

int SqliteBytes::open_file(sqlite3_vfs* system, const char* /*name*/, sqlite3_file* file, int flags,
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

/// What is behind the end is zeros.
int SqliteBytes::read_file(sqlite3_file* file, void* to, int count, sqlite3_int64 at) {
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

int SqliteBytes::tell_size(sqlite3_file* file, sqlite3_int64* size) {
    *size = static_cast<sqlite3_int64>(owner_of(file)->bytes_.size());
    return SQLITE_OK;
}

/// A file system in which these bytes are the only file.
sqlite3_vfs SqliteBytes::file_system(SqliteBytes& of) {
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

int SqliteBytes::is_enough(void* database) {
    SqliteBytes& self = *static_cast<SqliteBytes*>(database);
    constexpr std::uint64_t least = 10'000;  // thousands of steps: a second's tenth
    return ++self.steps_ > least + self.bytes_.size() / (2 * steps_at_once) || stop_requested() ? 1 : 0;
}

Result<std::unique_ptr<SqliteBytes>> SqliteBytes::open(ByteSource& bytes) {
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

SqliteBytes::~SqliteBytes() {
    sqlite3_blob_close(blob_);
    sqlite3_close(database_);
}

Error SqliteBytes::failed() {
    if (unread_) {
        Error why = std::move(*unread_);
        unread_.reset();
        return why;
    }
    if (stop_requested()) return {ErrorKind::interrupted, "interrupted while it was read"};
    const int status = database_ != nullptr ? sqlite3_errcode(database_) : SQLITE_NOMEM;
    if (status == SQLITE_NOMEM) return {ErrorKind::internal, "SQLite is out of memory"};
    if (status == SQLITE_INTERRUPT) return input_error("is damaged: SQLite comes to no end with it");
    return input_error((status == SQLITE_ERROR ? "is not as ROS 2 writes it" : "is damaged") +
                       std::string(", as SQLite says: ") + printable(sqlite3_errmsg(database_), 100));
}

Result<void> SqliteBytes::each_row(const char* statement,
                                   const std::function<Result<void>(sqlite3_stmt&)>& row) {
    steps_ = 0;
    sqlite3_stmt* prepared = nullptr;
    const int status = sqlite3_prepare_v2(database_, statement, -1, &prepared, nullptr);
    const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> closer(prepared, sqlite3_finalize);
    if (status != SQLITE_OK) return failed();
    for (;;) {
        const int step = sqlite3_step(prepared);
        if (step == SQLITE_DONE) return {};
        if (step != SQLITE_ROW) return failed();
        if (auto taken = row(*prepared); !taken) return taken;
    }
}

Result<std::uint64_t> SqliteBytes::find_blob(const char* table, const char* column, std::int64_t row) {
    steps_ = 0;
    const int status = blob_ != nullptr ? sqlite3_blob_reopen(blob_, row)
                                        : sqlite3_blob_open(database_, "main", table, column, row, 0, &blob_);
    if (status == SQLITE_OK) return static_cast<std::uint64_t>(sqlite3_blob_bytes(blob_));
    Error why = failed();
    sqlite3_blob_close(blob_);
    blob_ = nullptr;
    return why;
}

Result<std::string> SqliteBytes::read_blob(std::size_t count) {
    std::string value(count, '\0');
    if (sqlite3_blob_read(blob_, value.data(), static_cast<int>(count), 0) != SQLITE_OK) return failed();
    return value;
}

bool is_sqlite(std::string_view begin) {
    return begin.starts_with(sqlite_magic);
}

}  // namespace touchable
