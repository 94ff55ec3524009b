#include "engine/clip/track_thread.hpp"

#include <utility>

#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// Packets of a track under way: one being decoded while another waits.
constexpr std::size_t packets_ahead = 2;
/// From this many pixels on a picture is worth a thread.
constexpr std::int64_t pixels_for_thread = 50'000;

std::optional<TrackDecoder::Picture> end_of_track() {
    return {};
}

}  // namespace

TrackThread::TrackThread(TrackDecoder decoder, int stream, Fit fit)
    : decoder_(std::move(decoder)),
      stream_(stream),
      name_(decoder_.name()),
      fit_(std::move(fit)),
      threaded_(decoder_.pixels() >= pixels_for_thread) {}

TrackThread::~TrackThread() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void TrackThread::restart(std::int64_t frame) {
    std::unique_lock lock(mutex_);
    jobs_.clear();
    changed_.wait(lock, [this] { return !working_; });
    if (thrown_) {  // its thread has ended with that
        lock.unlock();
        thread_.join();
        lock.lock();
        thrown_ = nullptr;
    }
    outcomes_.clear();
    decoder_.restart(frame);
    final_.reset();
    all_read_ = false;
}

void TrackThread::fill(Demuxer& file) {
    while (threaded_ && has_room()) push(file);
}

bool TrackThread::has_room() {
    if (all_read_) return false;
    const std::lock_guard lock(mutex_);
    return jobs_.size() + outcomes_.size() + (working_ ? 1 : 0) < packets_ahead;
}

void TrackThread::push(Demuxer& file) {
    auto packet = file.next(stream_);
    all_read_ = !packet || !*packet;
    std::unique_lock lock(mutex_);
    jobs_.push_back({std::move(packet), left_out_});
    lock.unlock();
    changed_.notify_all();
    if (!threaded_ || thread_.joinable()) return;
    if (auto started = start_thread(thread_, "track-decoder", "that decodes a track", [this] { run(); });
        !started)
        give(started.error());
}

Result<std::optional<TrackDecoder::Picture>> TrackThread::next(Demuxer& file) {
    while (!final_) {
        if (auto outcome = take()) {
            if (outcome->ok() && **outcome) return std::move(*outcome);
            final_ = std::move(outcome);
        } else {
            push(file);
        }
    }
    return final_->ok() ? Outcome(end_of_track()) : Outcome(final_->error());
}

/// Nothing: a further packet is needed.
std::optional<TrackThread::Outcome> TrackThread::take() {
    std::unique_lock lock(mutex_);
    if (!threaded_ && outcomes_.empty() && !jobs_.empty()) {
        const Job job = std::move(jobs_.front());
        jobs_.pop_front();
        lock.unlock();
        work(job);
        lock.lock();
    }
    changed_.wait(lock, [this] { return !outcomes_.empty() || thrown_ || (jobs_.empty() && !working_); });
    if (!outcomes_.empty()) {
        auto outcome = std::move(outcomes_.front());
        outcomes_.pop_front();
        return outcome;
    }
    if (thrown_) std::rethrow_exception(thrown_);
    return std::nullopt;
}

/// Nothing thrown leaves the thread: who reads the pictures gets it.
void TrackThread::run() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
        if (stopping_) return;
        const Job job = std::move(jobs_.front());
        jobs_.pop_front();
        working_ = true;
        lock.unlock();
        std::exception_ptr thrown;
        try {
            work(job);
        } catch (...) {
            thrown = std::current_exception();
        }
        lock.lock();
        working_ = false;
        thrown_ = thrown;
        changed_.notify_all();
        if (thrown_) return;
    }
}

void TrackThread::work(const Job& job) {
    if (!job.packet) return give(job.packet.error());
    const AVPacket* packet = job.packet->get();
    if (packet && job.left_out && decoder_.is_one_packet_each()) {
        auto skipped = decoder_.skip(*packet);
        return give(skipped ? Outcome(std::optional(std::move(*skipped))) : Outcome(skipped.error()));
    }
    if (auto sent = decoder_.send(packet); !sent) return give(sent.error());
    while (true) {
        auto decoded = decoder_.receive();
        if (!decoded) return give(decoded.error());
        if (!*decoded) break;
        give(fitted(std::move(**decoded)));
    }
    if (!packet) give(end_of_track());
}

TrackThread::Outcome TrackThread::fitted(TrackDecoder::Picture picture) {
    TRY_ASSIGN(auto plane,
               fit_(std::move(picture.plane), name_ + ", frame " + std::to_string(picture.number)));
    if (!same_samples(plane.view, newest_.view)) newest_ = std::move(plane);
    picture.plane = newest_;
    return std::optional(std::move(picture));
}

void TrackThread::give(Outcome outcome) {
    {
        const std::lock_guard lock(mutex_);
        outcomes_.push_back(std::move(outcome));
    }
    changed_.notify_all();
}

}  // namespace touchable
