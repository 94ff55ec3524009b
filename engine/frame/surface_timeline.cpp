#include "engine/frame/surface_timeline.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <string>

namespace touchable {

namespace {

/// Ring entries per slot: how far unchanged frames may be published ahead of the reader, and how many entries
/// one look can walk over.
constexpr std::size_t entries_per_slot = 4;

static_assert(std::atomic<std::uint64_t>::is_always_lock_free &&
              std::atomic<std::int64_t>::is_always_lock_free);

/// later - earlier, exact for any two times.
double nanoseconds_between(std::int64_t earlier, std::int64_t later) {
    return static_cast<double>(static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier));
}

}  // namespace

SurfaceTimeline::SurfaceTimeline(int slots) : newest_time_(std::numeric_limits<std::int64_t>::min()) {
    assert(slots >= 3);
    const auto count = static_cast<std::size_t>(slots);
    for (std::size_t k = 0; k < count; ++k) slots_.push_back(std::make_unique<SurfaceFrame>());
    free_from_.assign(count, 0);
    entries_.resize(count * entries_per_slot);
}

SurfaceFrame* SurfaceTimeline::acquire() {
    if (acquired_) return slots_[*acquired_].get();
    const std::uint64_t oldest = reader_oldest_.load(std::memory_order_acquire);
    if (published_.load(std::memory_order_relaxed) - oldest == entries_.size()) return nullptr;
    // Of the free slots the one used last: the least has changed since the frame it holds.
    for (std::size_t slot = 0; slot < slots_.size(); ++slot)
        if (free_from_[slot] <= oldest && (!acquired_ || free_from_[slot] > free_from_[*acquired_]))
            acquired_ = slot;
    return acquired_ ? slots_[*acquired_].get() : nullptr;
}

Result<void> SurfaceTimeline::publish(std::int64_t number, std::int64_t time_ns) {
    if (!acquired_) return Error{ErrorKind::internal, "timeline: publish without an acquired frame"};
    if (auto later = check_later(number, time_ns); !later) return later;
    append(number, time_ns, *acquired_);
    acquired_.reset();
    return {};
}

Result<bool> SurfaceTimeline::republish(std::int64_t number, std::int64_t time_ns) {
    const std::uint64_t published = published_.load(std::memory_order_relaxed);
    if (published == 0) return Error{ErrorKind::internal, "timeline: republish before the first frame"};
    if (auto later = check_later(number, time_ns); !later) return later.error();
    // One entry stays free, so that publishing an acquired slot never meets a full ring.
    const std::uint64_t held = published - reader_oldest_.load(std::memory_order_acquire);
    if (held + 1 >= entries_.size()) return false;
    append(number, time_ns, entry(published - 1).slot);
    return true;
}

Result<void> SurfaceTimeline::check_later(std::int64_t number, std::int64_t time_ns) const {
    const std::int64_t newest = newest_time_.load(std::memory_order_relaxed);
    if (time_ns > newest) return {};
    return input_error("frame " + std::to_string(number) + ": its time " + std::to_string(time_ns) +
                       " ns is not after the previous frame's " + std::to_string(newest) +
                       " ns; times must increase from frame to frame");
}

void SurfaceTimeline::append(std::int64_t number, std::int64_t time_ns, std::size_t slot) {
    const std::uint64_t sequence = published_.load(std::memory_order_relaxed);
    entries_[sequence % entries_.size()] = {number, time_ns, slot};
    free_from_[slot] = sequence + 1;
    published_.store(sequence + 1, std::memory_order_release);
    newest_time_.store(time_ns, std::memory_order_release);
}

std::int64_t SurfaceTimeline::newest_time() const {
    return newest_time_.load(std::memory_order_acquire);
}

TimedFrame SurfaceTimeline::timed_frame(std::uint64_t sequence) const {
    const Entry& e = entry(sequence);
    return {e.number, e.time_ns, slots_[e.slot].get()};
}

bool SurfaceTimeline::pair_at(std::int64_t time_ns, FramePair& pair) {
    const std::uint64_t published = published_.load(std::memory_order_acquire);
    if (published == 0) return false;
    std::uint64_t prev = reader_oldest_.load(std::memory_order_relaxed);  // only the reader writes it
    while (prev + 1 < published && entry(prev + 1).time_ns <= time_ns) ++prev;

    pair.prev = pair.next = timed_frame(prev);
    pair.blend = 0;
    if (prev + 1 < published && time_ns >= pair.prev.time_ns) {
        pair.next = timed_frame(prev + 1);
        const double blend = nanoseconds_between(pair.prev.time_ns, time_ns) /
                             nanoseconds_between(pair.prev.time_ns, pair.next.time_ns);
        pair.blend = std::min(blend, 1 - 0x1p-53);  // frames months apart could round to 1
    }
    reader_oldest_.store(prev, std::memory_order_release);
    return true;
}

}  // namespace touchable
