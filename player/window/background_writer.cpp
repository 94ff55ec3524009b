// SPDX-License-Identifier: Apache-2.0
#include "player/window/background_writer.hpp"

#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <deque>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

int write_all(int out, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(out, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return errno;
        if (count == 0) return ENOSPC;
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return 0;
}

}  // namespace

struct BackgroundWriter::Queue {
    bool is_done() const { return waiting.empty() && !at_work; }
    /// The CPU time of its thread, which has not ended.
    std::int64_t worked_ns() const {
        timespec worked{};
        if (has_thread) clock_gettime(thread_clock, &worked);
        return worked.tv_sec * std::int64_t{1'000'000'000} + worked.tv_nsec;
    }
    static Result<void> start(const std::shared_ptr<Queue>& queue);
    void work();
    void refuse(const Job& job, const std::string& why) {
        done.push_back(
            {job.file, job.tag, input_error((job.file.empty() ? what : job.file.string()) + ": " + why)});
    }

    const std::string what;
    const std::size_t most_waiting;
    char thread_name[16]{};
    std::mutex mutex{};
    std::condition_variable changed{};  // signalled when a job is done
    // Guarded by `mutex`.
    std::deque<Job> waiting{};
    std::optional<Job> at_work{};  // without its closures; empty: none, or it was dropped
    std::vector<Written> done{};
    bool has_thread = false, is_abandoned = false;
    clockid_t thread_clock = CLOCK_MONOTONIC;  // of its CPU time, if it has begun
};

BackgroundWriter::BackgroundWriter(std::string_view thread, std::string what, std::size_t most_waiting)
    : queue_(new Queue{.what = std::move(what), .most_waiting = most_waiting}) {
    thread.copy(queue_->thread_name, sizeof queue_->thread_name - 1);
}

BackgroundWriter::~BackgroundWriter() {
    std::unique_lock lock(queue_->mutex);
    if (queue_->is_abandoned) return;
    lock.unlock();
    finish(std::chrono::seconds(2), Late::done);
}

void BackgroundWriter::give(Job job) {
    Queue& queue = *queue_;
    const std::lock_guard lock(queue.mutex);
    for (Job& earlier : queue.waiting)
        if (job.replaces && earlier.file == job.file) {
            earlier = std::move(job);
            return;
        }
    if (queue.waiting.size() + (queue.at_work ? 1 : 0) >= queue.most_waiting)
        return queue.refuse(job, "not written: " + std::to_string(queue.most_waiting) + " " + queue.what +
                                     " are still being written");
    queue.waiting.push_back(std::move(job));
    (void)Queue::start(queue_);
}

/// If the machine has no thread left, the writer's next call tries again.
Result<void> BackgroundWriter::Queue::start(const std::shared_ptr<Queue>& queue) {
    if (queue->has_thread || queue->waiting.empty()) return {};
    std::thread thread;
    const std::string purpose = "that writes " + queue->what;
    TRY(start_thread(thread, queue->thread_name, purpose.c_str(), [queue] { queue->work(); }));
    thread.detach();
    queue->has_thread = true;
    return {};
}

void BackgroundWriter::Queue::work() {
    std::unique_lock lock(mutex);
    pthread_getcpuclockid(pthread_self(), &thread_clock);
    while (!waiting.empty()) {
        Job job = std::move(waiting.front());
        waiting.pop_front();
        at_work = Job{.file = job.file, .tag = job.tag};
        lock.unlock();
        if (job.file.empty() && job.name) {
            job.file = job.name();
            const std::lock_guard named(mutex);
            if (at_work)
                at_work->file = job.file;
            else
                job.write = [](const auto&) -> Result<void> { return {}; };  // dropped meanwhile
        }
        auto result = job.write(job.file);
        job.write = nullptr;  // releases its data before it counts as done
        lock.lock();
        if (at_work) done.push_back({job.file, job.tag, std::move(result)});
        at_work.reset();
        changed.notify_all();
    }
    has_thread = false;
    if (std::exchange(is_abandoned, false)) --abandoned_threads;
}

std::vector<BackgroundWriter::Written> BackgroundWriter::take() {
    const std::lock_guard lock(queue_->mutex);
    (void)Queue::start(queue_);
    return std::exchange(queue_->done, {});
}

std::function<bool()> BackgroundWriter::waits_for(const std::filesystem::path& file) const {
    return [queue = queue_, file] {
        const std::lock_guard lock(queue->mutex);
        const auto is_for_it = [&file](const Job& job) { return job.file == file; };
        return (queue->at_work && is_for_it(*queue->at_work)) ||
               std::ranges::any_of(queue->waiting, is_for_it);
    };
}

bool BackgroundWriter::wait(std::chrono::milliseconds longest) const {
    std::unique_lock lock(queue_->mutex);
    (void)Queue::start(queue_);
    return queue_->changed.wait_for(lock, longest, [this] { return queue_->is_done(); });
}

bool BackgroundWriter::finish(std::chrono::milliseconds longest, Late late) {
    Queue& queue = *queue_;
    std::unique_lock lock(queue.mutex);
    if (const auto begun = Queue::start(queue_); !begun) {
        for (const Job& job : std::exchange(queue.waiting, {}))
            queue.done.push_back({job.file, job.tag, begun.error()});
        return false;
    }
    std::int64_t worked_ns;
    do {
        worked_ns = queue.worked_ns();
        if (queue.changed.wait_for(lock, longest, [&queue] { return queue.is_done(); })) return true;
    } while (late == Late::dropped && queue.worked_ns() != worked_ns && !stop_requested());
    if (!std::exchange(queue.is_abandoned, true)) ++abandoned_threads;
    if (late == Late::done) return false;
    if (queue.at_work) queue.waiting.push_front(*std::exchange(queue.at_work, {}));
    for (const Job& job : queue.waiting) queue.refuse(job, not_in_time);
    queue.waiting.clear();
    return false;
}

/// A failed sync is not retried: Linux reports a failed write once, then forgets it.
int append_durably(int out, std::string_view rows) {
    const off_t before = lseek(out, 0, SEEK_END);
    int why = write_all(out, rows);
    if (why == 0 && fdatasync(out) != 0) why = errno;
    if (why != 0 && before >= 0) (void)!ftruncate(out, before);
    return why;
}

}  // namespace touchable
