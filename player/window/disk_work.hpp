#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

#include "engine/base/result.hpp"
#include "engine/base/start_thread.hpp"

namespace touchable {

/// Work with files on a thread of its own, one job after the other, as they were given: a disk that hangs
/// holds up nobody who gives. What jobs work on is theirs, for as long as one of them is left: where the disk
/// never answers, nobody waits any more (abandoned_threads).
class DiskWork {
public:
    using Job = std::function<void()>;  ///< throws nothing

    /// `name` and `what` as start_thread has them.
    template <std::size_t bytes>
    static Result<std::unique_ptr<DiskWork>> start(const char (&name)[bytes], const char* what) {
        std::unique_ptr<DiskWork> made(new DiskWork);
        std::thread thread;
        auto begun = start_thread(thread, name, what, [jobs = made->jobs_] { do_all(*jobs); });
        made->is_finished_ = !begun.ok();
        if (!begun.ok()) return begun.error();
        thread.detach();  // its end is waited for, but not for ever
        return made;
    }
    /// Finishes where nobody did.
    ~DiskWork();
    DiskWork(const DiskWork&) = delete;
    DiskWork& operator=(const DiskWork&) = delete;

    void give(Job job);
    /// Jobs that nobody has begun yet.
    std::size_t waiting() const;
    /// Whether all that was given is done, after that long at most.
    bool wait(std::chrono::milliseconds longest) const;
    /// Once, the last call: likewise, and the thread ends. A second time only where it had not.
    bool finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

private:
    struct Jobs;
    DiskWork();
    static void do_all(Jobs& jobs);

    const std::shared_ptr<Jobs> jobs_;  // the thread's, too
    bool is_finished_ = false;          // or waited for long enough
};

/// Of a file that nobody waits for any more.
inline Error disk_does_not_answer(const std::filesystem::path& file) {
    return input_error(file.string() + ": not finished: its disk does not answer");
}

}  // namespace touchable
