// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files that a window writes while it runs, off its thread: a disk that hangs stops neither the picture nor
// the key that switches the force off.
//
// A BackgroundWriter has a queue of jobs and one thread that runs them in order. A job writes one file, or a
// row of one, and owns all data that it uses. `give` never waits; `take` returns the results, once each:
// success, or the error. Each kind of file has its own writer (pictures of the window, painted materials, the
// usage log, a study's results), since each may be on its own disk.
//
// Threads: the thread starts with a job and ends with an empty queue. Job::write and Job::name run on it, and
// finished jobs' data is destroyed there. If the machine has no thread left, jobs wait until a later call
// gets one. Any thread may call all members of the writer.
//
// If a disk hangs, only `finish` waits for it, at the end and for two seconds. Then the thread is abandoned
// and counts in abandoned_threads, so that the program ends with std::_Exit. Jobs that have not begun are
// dropped, and `take` returns an error for each ("FILE: " + not_in_time); or, for
// rows of tables, which may come late, they are run once the disk answers, if the program still lives.

#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// Why a writer gave up; it does not know whether its thread waits for the disk or for the CPU.
inline constexpr const char* not_in_time = "not written in time: the disk hangs, or this machine is busy";

class BackgroundWriter : NonCopyable {
public:
    struct Job {
        std::filesystem::path file{};  ///< name for errors; empty: `name` provides it
        /// Writes the file, or returns the error; does not throw.
        std::function<Result<void>(const std::filesystem::path& file)> write{};
        std::string tag{};  ///< returned with the result
        bool replaces =
            false;  ///< takes the place in the queue of a job for the same file that has not begun
        std::function<std::filesystem::path()> name{};
    };
    struct Written {
        std::filesystem::path file;
        std::string tag;
        Result<void> result;
    };
    /// The fate of jobs for which `finish` no longer waits.
    enum class Late { dropped, done };

    /// `thread`: its name, at most 15 bytes. `what`: the jobs' content, for errors: "pictures of the window".
    /// `most_waiting`: queue length from which further jobs are refused.
    BackgroundWriter(std::string_view thread, std::string what,
                     std::size_t most_waiting = std::numeric_limits<std::size_t>::max());
    /// Waits like `finish`, unless `finish` has timed out; late jobs are run.
    ~BackgroundWriter();

    /// Queues a job; a refused job's result is an error.
    void give(Job job);
    /// Results since the last call, oldest first.
    std::vector<Written> take();
    /// A function that tells whether a job for this file is unfinished; may outlive the writer.
    std::function<bool()> waits_for(const std::filesystem::path& file) const;
    /// Waits for `longest` at most; returns whether all jobs are done.
    bool wait(std::chrono::milliseconds longest) const;
    /// Waits like `wait`; if the jobs are not done in time, abandons the thread. One that still computes has
    /// no disk that hangs: with Late::dropped it is waited for, until work is to stop.
    bool finish(std::chrono::milliseconds longest = std::chrono::seconds(2), Late late = Late::dropped);

private:
    struct Queue;
    const std::shared_ptr<Queue> queue_;  // shared with the thread
};

/// Appends all of `rows` to an open file and waits until they are synced to disk; on failure, appends none.
/// Returns 0, or an errno.
int append_durably(int out, std::string_view rows);

}  // namespace touchable
