#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "player/window/disk_work.hpp"
#include "player/window/durable_append.hpp"

namespace touchable {

/// How a kiosk is used: a table (CSV) of its starts, visits, faults and ends, which grows by a row as each
/// happens. It has nothing of persons. Rows are written on a thread of their own, each safe on the disk
/// before the next: a disk that hangs or is full, or a program that is killed, costs the rows of that time
/// and no more. No call waits for the disk but `finish`, for a while. All calls are the window's.
class UseLog {
public:
    using Time = std::chrono::system_clock::time_point;
    static constexpr const char* header = "time,event,visitor,seconds,words\n";

    /// Goes on with a log that is there. Refused (ErrorKind::input): a file that is none, one that cannot be
    /// written, one that another program is writing.
    static Result<std::unique_ptr<UseLog>> open(const std::filesystem::path& file) {
        return open(file, append_durably);
    }
    using WriteRow = std::function<int(int out, std::string_view row)>;  ///< append_durably, or as it does
    /// Likewise with rows written so, such as by a test's disk.
    static Result<std::unique_ptr<UseLog>> open(const std::filesystem::path& file, WriteRow write);
    /// Once, the last call: writes what waits, for that long at most. An error where rows are missing.
    Result<void> finish(std::chrono::milliseconds longest = std::chrono::seconds(2));
    UseLog(const UseLog&) = delete;
    UseLog& operator=(const UseLog&) = delete;

    void start(Time now) { add(now, "start,,,"); }
    /// Somebody came then, and was there for so long. Visitors are numbered from 1, since `open`.
    void visit(Time came, double seconds);
    void fault(Time now, const std::string& words);
    void end(Time now) { add(now, "end,,,"); }
    std::int64_t visitors() const { return visitors_; }

    /// Why rows are missing, of the first that is; nothing where none is.
    std::optional<Error> missing() const;

private:
    /// What the thread that writes works on.
    struct Rows;
    UseLog(std::shared_ptr<Rows> rows, std::unique_ptr<DiskWork> disk)
        : rows_(std::move(rows)), disk_(std::move(disk)) {}
    void add(Time time, const std::string& rest);

    const std::shared_ptr<Rows> rows_;
    const std::unique_ptr<DiskWork> disk_;
    std::int64_t visitors_ = 0;
};

}  // namespace touchable
