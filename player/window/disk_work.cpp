#include "player/window/disk_work.hpp"

#include <condition_variable>
#include <deque>
#include <mutex>

#include "engine/base/unless_stopped.hpp"

namespace touchable {

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
        job = nullptr;  // what it holds is let go of before anybody is told
        lock.lock();
        jobs.is_busy = false;
        jobs.changed.notify_all();
    }
    jobs.has_ended = true;
    if (jobs.is_abandoned) --abandoned_threads;
    jobs.changed.notify_all();
}

}  // namespace touchable
