#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "engine/result.hpp"

namespace touchable {

/// How a kiosk is used: a table (CSV) of its starts, visits, faults and ends, which grows by a row as each
/// happens. It has nothing of persons. Rows are written on a thread of their own, each safe on the disk
/// before the next: a disk that hangs or is full, or a program that is killed, costs the rows of that time
/// and no more. All calls are the window's.
class UseLog {
public:
    using Time = std::chrono::system_clock::time_point;
    static constexpr const char* header = "time,event,visitor,seconds,words\n";

    /// Goes on with a log that is there. Refused (ErrorKind::input): a file that is none, one that cannot be
    /// written, one that another program is writing.
    static Result<std::unique_ptr<UseLog>> open(const std::filesystem::path& file);
    /// Writes what waits.
    ~UseLog();
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
    UseLog(std::filesystem::path file, int out) : file_(std::move(file)), out_(out) {}
    void add(Time time, const std::string& rest);
    void write_all();
    int write(const std::string& row) const;

    static constexpr std::size_t most_waiting = 1000;
    const std::filesystem::path file_;
    const int out_;
    std::int64_t visitors_ = 0;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by it.
    std::deque<std::string> waiting_;
    std::optional<Error> missing_;
    bool is_ending_ = false;
    std::thread thread_;
};

}  // namespace touchable
