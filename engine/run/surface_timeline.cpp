// SPDX-License-Identifier: Apache-2.0
#include "engine/run/surface_timeline.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <string>

#include "engine/base/try.hpp"

namespace touchable {

namespace {

/// Ring entries per slot: how far unchanged frames may be published ahead of the reader, and how many entries
/// one look can walk over.
constexpr std::size_t entries_per_slot = 4;
/// A flag in `between_`, beside the place.
constexpr std::size_t is_new = 4;

static_assert(std::atomic<std::uint64_t>::is_always_lock_free &&
              std::atomic<std::int64_t>::is_always_lock_free);

/// Two slots in one word, 0 standing for none.
std::uint64_t pins(std::size_t one, std::size_t other) {
    return std::uint64_t{one + 1} << 32 | std::uint64_t{other + 1};
}
bool is_pinned(const auto& pins, std::size_t slot) {
    return std::ranges::any_of(pins, [slot](std::uint64_t pair) {
        return pair >> 32 == slot + 1 || (pair & 0xffffffffU) == slot + 1;
    });
}

/// later - earlier, exact for any two times.
double nanoseconds_between(std::int64_t earlier, std::int64_t later) {
    return static_cast<double>(static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier));
}

}  // namespace

SurfaceTimeline::SurfaceTimeline(int slots, Eye eye)
    : eye_(eye), newest_time_(std::numeric_limits<std::int64_t>::min()) {
    assert(slots >= (eye == Eye::none ? 3 : 5));
    const auto count = static_cast<std::size_t>(slots);
    for (std::size_t k = 0; k < count; ++k) slots_.push_back(std::make_unique<SurfaceFrame>());
    free_from_.assign(count, 0);
    entries_.resize(count * entries_per_slot);
}

/// Read after `reader_oldest_`, and the reader's own pins first: a slot that has left one is in the next by
/// then.
SurfaceTimeline::Pins SurfaceTimeline::all_pins() const {
    Pins pins{pinned_.load(std::memory_order_acquire)};
    for (std::size_t place = 0; place < shown_pins_.size(); ++place)
        pins[place + 1] = shown_pins_[place].load(std::memory_order_acquire);
    return pins;
}

SurfaceFrame* SurfaceTimeline::acquire() {
    if (acquired_) return slots_[*acquired_].get();
    const std::uint64_t oldest = reader_oldest_.load(std::memory_order_acquire);
    if (published_.load(std::memory_order_relaxed) - oldest == entries_.size()) return nullptr;
    const Pins pins = all_pins();
    // Take the free slot that was used last: the least has changed since its frame.
    for (std::size_t slot = 0; slot < slots_.size(); ++slot)
        if (free_from_[slot] <= oldest && !is_pinned(pins, slot) &&
            (!acquired_ || free_from_[slot] > free_from_[*acquired_]))
            acquired_ = slot;
    return acquired_ ? slots_[*acquired_].get() : nullptr;
}

void SurfaceTimeline::begin_epoch(std::uint64_t epoch) {
    assert(epoch > epoch_ && slots_.size() >= 4);
    epoch_ = epoch;
    epoch_has_frames_ = false;
    newest_time_.store(std::numeric_limits<std::int64_t>::min(), std::memory_order_release);
}

Result<void> SurfaceTimeline::publish(std::int64_t number, std::int64_t time_ns) {
    if (!acquired_) return internal_error("timeline: publish without an acquired frame");
    TRY(check_later(number, time_ns));
    slots_[*acquired_]->content = new_content_number();
    append(number, time_ns, *acquired_);
    acquired_.reset();
    return {};
}

Result<bool> SurfaceTimeline::republish(std::int64_t number, std::int64_t time_ns) {
    const std::uint64_t published = published_.load(std::memory_order_relaxed);
    if (!epoch_has_frames_) return internal_error("timeline: republish before the first frame of its epoch");
    // A reader that skipped the epoch has released its frames.
    if (acquired_ == entry(published - 1).slot)
        return internal_error("timeline: republish of a frame that is being built anew");
    TRY(check_later(number, time_ns));
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
    entries_[sequence % entries_.size()] = {number, time_ns, epoch_, slot};
    epoch_has_frames_ = true;
    free_from_[slot] = sequence + 1;
    published_.store(sequence + 1, std::memory_order_release);
    newest_time_.store(time_ns, std::memory_order_release);
}

TimedFrame SurfaceTimeline::timed_frame(std::uint64_t sequence) const {
    const Entry& e = entry(sequence);
    return {e.number, e.time_ns, slots_[e.slot].get()};
}

void SurfaceTimeline::hold(std::uint64_t prev, std::uint64_t next, double blend) {
    held_ = FramePair{timed_frame(prev), timed_frame(next), blend, entry(prev).epoch};
    pinned_.store(pins(entry(prev).slot, entry(next).slot), std::memory_order_release);
}

/// Skips entries of earlier epochs; returns false if the current pair is to stay.
bool SurfaceTimeline::go_over(std::uint64_t epoch, bool ended, std::uint64_t published,
                              std::uint64_t& first) {
    while (first < published && entry(first).epoch < epoch) ++first;
    if (first == published || entry(first).epoch != epoch) return false;
    return ended || first + 1 < published;
}

bool SurfaceTimeline::pair_at(std::int64_t time_ns, FramePair& pair) {
    return pair_at(MediaMoment{held_ ? held_->epoch : 0, time_ns, 0}, pair);
}

bool SurfaceTimeline::pair_at(const MediaMoment& moment, FramePair& pair) {
    const bool ended = ended_.load(std::memory_order_acquire) == moment.epoch + 1;
    const std::uint64_t published = published_.load(std::memory_order_acquire);
    if (published == 0) return false;
    std::uint64_t prev = reader_oldest_.load(std::memory_order_relaxed);  // only the reader writes it
    if (!held_) hold(prev, prev, 0);
    const bool there = moment.epoch > held_->epoch ? go_over(moment.epoch, ended, published, prev)
                                                   : prev < published && entry(prev).epoch == held_->epoch &&
                                                         moment.epoch == held_->epoch;
    if (there) {
        const auto follows = [&](std::uint64_t next) {
            return next < published && entry(next).epoch == moment.epoch;
        };
        while (follows(prev + 1) && entry(prev + 1).time_ns <= moment.time_ns) ++prev;
        const std::int64_t from = entry(prev).time_ns;
        if (follows(prev + 1) && moment.time_ns >= from) {
            const double blend = nanoseconds_between(from, moment.time_ns) /
                                 nanoseconds_between(from, entry(prev + 1).time_ns);
            hold(prev, prev + 1, std::min(blend, 1 - 0x1p-53));  // frames months apart could round to 1
        } else {
            hold(prev, prev, 0);
        }
    }
    pair = *held_;
    reader_oldest_.store(prev, std::memory_order_release);
    return true;
}

void SurfaceTimeline::show(std::int64_t tick) {
    if (eye_ == Eye::none || !held_) return;
    shown_[readers_place_] = {*held_, tick};
    shown_pins_[readers_place_].store(pinned_.load(std::memory_order_relaxed), std::memory_order_release);
    readers_place_ = between_.exchange(readers_place_ | is_new, std::memory_order_acq_rel) & ~is_new;
    shown_pins_[readers_place_].store(0, std::memory_order_release);
}

const SurfaceTimeline::HeldPair* SurfaceTimeline::look() {
    if (between_.load(std::memory_order_relaxed) & is_new) {
        shown_pins_[eyes_place_].store(0, std::memory_order_release);
        eyes_place_ = between_.exchange(eyes_place_, std::memory_order_acq_rel) & ~is_new;
        eye_has_seen_ = true;
    }
    return eye_has_seen_ ? &shown_[eyes_place_] : nullptr;
}

}  // namespace touchable
