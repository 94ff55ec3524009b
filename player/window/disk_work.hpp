#pragma once

// Files that a window writes while it runs: off its thread, so that a disk that hangs does not stop the
// picture, and row by row, so that a machine that is switched off loses no row that was written before.

#include <filesystem>
#include <functional>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"

namespace touchable {

/// Work with files on a thread of its own, one job after the other, in the order in which they were given: a
/// disk that hangs does not hold up the callers. Jobs own what they work on: if the disk never answers, the
/// thread is left behind with it (abandoned_threads).
class DiskWork {
public:
    using Job = std::function<void()>;  ///< throws nothing

    /// `name` and `what` as start_thread has them.
    template <std::size_t bytes>
    static Result<std::unique_ptr<DiskWork>> start(const char (&name)[bytes], const char* what) {
        std::unique_ptr<DiskWork> made(new DiskWork);
        std::thread thread;
        auto begun = start_thread(thread, name, what, [jobs = made->jobs_] { do_all(*jobs); });
        made->is_finished_ = !begun;
        if (!begun) return begun.error();
        thread.detach();  // its end is waited for, but not for ever
        return made;
    }
    /// Finishes, if `finish` was not called.
    ~DiskWork();
    DiskWork(const DiskWork&) = delete;
    DiskWork& operator=(const DiskWork&) = delete;

    void give(Job job);
    /// Jobs that have not begun yet.
    std::size_t waiting() const;
    /// Whether all that was given is done, after that long at most.
    bool wait(std::chrono::milliseconds longest) const;
    /// Once, the last call: waits like `wait`, and the thread ends. A second time only if it had not.
    bool finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

private:
    struct Jobs;
    DiskWork();
    static void do_all(Jobs& jobs);

    const std::shared_ptr<Jobs> jobs_;  // the thread's, too
    bool is_finished_ = false;          // or waited for long enough
};

/// The error of a file that is not waited for any more.
inline Error disk_does_not_answer(const std::filesystem::path& file) {
    return input_error(file.string() + ": not finished: its disk does not answer");
}

/// Appends all of `rows` to an open file and waits until they are safe on its disk; if that fails, none of
/// them is in it. Returns 0, or an errno.
int append_durably(int out, std::string_view rows);

/// "2026-11-24T10:00:00Z": universal time, to the second.
std::string in_universal_time(std::chrono::system_clock::time_point time);

}  // namespace touchable
