#pragma once

// Files that a window writes while it runs, off its thread: a disk that hangs stops neither the picture nor
// the key that takes the force off.
//
// A BackgroundWriter has a queue of jobs and one thread that does them, in the order in which they are given.
// A job writes one file, or a row of one, and owns all that it uses. `give` never waits; `take` has the
// results, once each: a file is written, or an error says why not. Each kind of file has a writer of its own
// (pictures of the window, what is painted, the log of use, a study's results), since each may be on a disk
// of its own.
//
// Threads: the thread starts with a job and ends when none waits. Job::write and Job::name run there, and so
// does the destruction of what a job owns that is done. Where the machine has no thread left, jobs wait until
// a later call gets one. All members of the writer may be called by any thread.
//
// A disk that hangs: only `finish` waits for it, at the end and for two seconds. Then the thread is left
// behind and counts in abandoned_threads, so that the program ends by std::_Exit. Jobs that have not begun
// are dropped, and `take` has an error for each ("FILE: not finished: its disk does not answer"); or, as
// rows of tables, which may come late, they are done once the disk answers, if the program still lives then.

#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

class BackgroundWriter : NonCopyable {
public:
    struct Job {
        std::filesystem::path file{};  ///< as errors name it; empty: `name` finds it
        /// Writes the file, or says why not; throws nothing.
        std::function<Result<void>(const std::filesystem::path& file)> write{};
        std::string tag{};  ///< comes back with the result
        bool replaces =
            false;  ///< takes the place in the queue of a job for the same file that has not begun
        std::function<std::filesystem::path()> name{};
    };
    struct Written {
        std::filesystem::path file;
        std::string tag;
        Result<void> result;
    };
    /// What becomes of jobs that `finish` does not wait for any more.
    enum class Late { dropped, done };

    /// `thread`: its name, at most 15 bytes. `what` is written, for errors: "pictures of the window".
    /// `most_waiting`: with as many jobs in the queue a further one is refused.
    BackgroundWriter(std::string_view thread, std::string what,
                     std::size_t most_waiting = std::numeric_limits<std::size_t>::max());
    /// Waits as `finish` does, unless `finish` has waited in vain; late jobs are done.
    ~BackgroundWriter();

    /// A job that is refused has an error as its result.
    void give(Job job);
    /// Results since the last call, oldest first.
    std::vector<Written> take();
    /// Tells whether a job for this file is not done yet; also after the writer has gone.
    std::function<bool()> waits_for(const std::filesystem::path& file) const;
    /// Whether all jobs are done, after that long at most.
    bool wait(std::chrono::milliseconds longest) const;
    /// Waits as `wait` does; if the disk does not answer meanwhile, the thread is left behind.
    bool finish(std::chrono::milliseconds longest = std::chrono::seconds(2), Late late = Late::dropped);

private:
    struct Queue;
    const std::shared_ptr<Queue> queue_;  // the thread's, too
};

/// Appends all of `rows` to an open file and waits until they are safe on its disk; if that fails, none of
/// them is in it. Returns 0, or an errno.
int append_durably(int out, std::string_view rows);

}  // namespace touchable
