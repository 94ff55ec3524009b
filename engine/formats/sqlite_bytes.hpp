#pragma once

#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// A database of SQLite in bytes that anybody may have written. It is read as it is: no other file is opened
/// (neither journal nor write-ahead log), nothing is written, and neither views nor virtual tables nor
/// extensions answer. Errors say what is wrong, after a colon behind the file's name.
class SqliteBytes {
public:
    /// `bytes` outlive it.
    static Result<std::unique_ptr<SqliteBytes>> open(ByteSource& bytes);
    SqliteBytes(const SqliteBytes&) = delete;
    SqliteBytes& operator=(const SqliteBytes&) = delete;
    ~SqliteBytes();

    /// Calls `row` for every row that the statement answers with, until it fails. Answers take steps by the
    /// number of bytes; one that takes more is refused.
    Result<void> each_row(const char* statement, const std::function<Result<void>(sqlite3_stmt&)>& row);
    /// A value of bytes: its size, and then what it begins with. Of one value at a time.
    Result<std::uint64_t> find_blob(const char* table, const char* column, std::int64_t row);
    Result<std::string> read_blob(std::size_t count);

private:
    explicit SqliteBytes(ByteSource& bytes) : bytes_(bytes) {}
    Error failed();
    static sqlite3_vfs file_system(SqliteBytes& of);
    static int open_file(sqlite3_vfs* system, const char* name, sqlite3_file* file, int flags, int* given);
    static int read_file(sqlite3_file* file, void* to, int count, sqlite3_int64 at);
    static int tell_size(sqlite3_file* file, sqlite3_int64* size);
    static int is_enough(void* database);

    ByteSource& bytes_;
    std::string name_;  // of its own among SQLite's file systems
    sqlite3_vfs system_{};
    sqlite3* database_ = nullptr;
    sqlite3_blob* blob_ = nullptr;
    std::optional<Error> unread_;  // of the bytes
    std::uint64_t steps_ = 0;      // of the answer, thousands
};

/// Whether a file's first bytes are those of a database of SQLite.
bool is_sqlite(std::string_view begin);

}  // namespace touchable
