#include "player/window/disk_work.hpp"

#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <deque>

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

struct DiskWork::Jobs {
    std::mutex mutex;
    std::condition_variable changed;
    // Guarded by it.
    std::deque<Job> waiting;
    bool is_busy = false, is_ending = false, has_ended = false, is_abandoned = false;
};

DiskWork::DiskWork() : jobs_(std::make_shared<Jobs>()) {}

DiskWork::~DiskWork() {
    if (!is_finished_) (void)finish();
}

void DiskWork::give(Job job) {
    {
        const std::lock_guard lock(jobs_->mutex);
        jobs_->waiting.push_back(std::move(job));
    }
    jobs_->changed.notify_all();
}

std::size_t DiskWork::waiting() const {
    const std::lock_guard lock(jobs_->mutex);
    return jobs_->waiting.size();
}

bool DiskWork::wait(std::chrono::milliseconds longest) const {
    std::unique_lock lock(jobs_->mutex);
    return jobs_->changed.wait_for(lock, longest,
                                   [this] { return jobs_->waiting.empty() && !jobs_->is_busy; });
}

bool DiskWork::finish(std::chrono::milliseconds longest) {
    is_finished_ = true;
    std::unique_lock lock(jobs_->mutex);
    jobs_->is_ending = true;
    jobs_->changed.notify_all();
    const bool has_ended = jobs_->changed.wait_for(lock, longest, [this] { return jobs_->has_ended; });
    if (!has_ended && !std::exchange(jobs_->is_abandoned, true)) ++abandoned_threads;
    return has_ended;
}

void DiskWork::do_all(Jobs& jobs) {
    std::unique_lock lock(jobs.mutex);
    for (;;) {
        jobs.changed.wait(lock, [&jobs] { return jobs.is_ending || !jobs.waiting.empty(); });
        if (jobs.waiting.empty()) break;
        Job job = std::move(jobs.waiting.front());
        jobs.waiting.pop_front();
        jobs.is_busy = true;
        lock.unlock();
        job();
        job = nullptr;  // frees what it holds before it counts as done
        lock.lock();
        jobs.is_busy = false;
        jobs.changed.notify_all();
    }
    jobs.has_ended = true;
    if (jobs.is_abandoned) --abandoned_threads;
    jobs.changed.notify_all();
}

/// A sync that failed is not tried again: Linux reports a row that it could not write once, and then forgets
/// it.
int append_durably(int out, std::string_view rows) {
    const off_t before = lseek(out, 0, SEEK_END);
    int why = write_all(out, rows);
    if (why == 0 && fdatasync(out) != 0) why = errno;
    if (why != 0 && before >= 0) (void)!ftruncate(out, before);
    return why;
}

std::string in_universal_time(std::chrono::system_clock::time_point time) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    char words[32];
    return {words, std::strftime(words, sizeof words, "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

}  // namespace touchable
