// SPDX-License-Identifier: Apache-2.0
#pragma once

// A SurfaceTimeline is the ring of published frames between the builder thread and the haptic thread. The
// builder fills a free slot and publishes it with a timestamp; the haptic thread gets the pair of frames
// around a moment and holds it, pinned, while it reads. Neither waits for the other, and nothing is allocated
// after the start. A moment has an epoch: a seek, the restart of a loop or another clip begins a new one, and
// a pair never spans two (docs/architecture.md, Time).
//
// Threads: one builds, one reads, and optionally one draws what the reader holds.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A moment on a clip's clock. Times go forward within an epoch; the next epoch may begin anywhere.
struct MediaMoment {
    std::uint64_t epoch = 0;
    std::int64_t time_ns = 0;
    std::int64_t start_ns = 0;  ///< where the epoch begins
    bool operator==(const MediaMoment&) const = default;
};

/// A ring of published SurfaceFrames between one writer (the surface thread) and one reader (the haptic
/// thread). The reader never waits; the writer's slots are recycled only once the reader has moved past them.
/// An eye (the drawing thread) may look at the pair that the reader holds; neither of the two waits for it.
/// No side locks, waits or retries: each works with what the others last stored.
class SurfaceTimeline {
public:
    /// The pair that the reader held in a tick.
    struct HeldPair {
        FramePair pair;
        std::int64_t tick = 0;
    };

    /// `slots`: frames that exist at once, at least 3 (the reader's pair, and one being built); 4 if epochs
    /// begin (the reader's pair, and that of the next epoch); with an eye 2 more.
    enum class Eye { none, one };
    explicit SurfaceTimeline(int slots, Eye eye = Eye::none);
    SurfaceTimeline(const SurfaceTimeline&) = delete;
    SurfaceTimeline& operator=(const SurfaceTimeline&) = delete;

    /// Writer. Returns a slot to build into, or nullptr while the reader still needs all slots (or all
    /// entries). The slot stays the writer's until it is published; another call returns the same one. It
    /// still holds the frame that it was last published with. Wait-free: one look at each slot.
    SurfaceFrame* acquire();
    /// Writer. Publishes the acquired slot; an entry for it is always free. A time not later than the newest
    /// one is refused, and the slot kept. Wait-free; only a refusal allocates, for its message.
    Result<void> publish(std::int64_t number, std::int64_t time_ns);
    /// Writer. Publishes the newest frame again, at a later time, if nothing changed. Returns false while the
    /// ring of entries is full, an error for a time not later or before the epoch's first frame. Wait-free.
    Result<bool> republish(std::int64_t number, std::int64_t time_ns);
    /// Writer. Frames published from now on belong to this epoch, which is later than the last; its times may
    /// begin anywhere. Wait-free.
    void begin_epoch(std::uint64_t epoch);
    /// Writer. The epoch of frames published from now on.
    std::uint64_t epoch() const { return epoch_; }
    /// Writer. Declares that the epoch gets no more frames. Wait-free.
    void end_epoch() { ended_.store(epoch_ + 1, std::memory_order_release); }

    /// Any thread. Time of the newest epoch's newest frame; INT64_MIN before the first. A reader that has
    /// seen this time finds the frame. Wait-free.
    std::int64_t newest_time() const { return newest_time_.load(std::memory_order_acquire); }

    /// Reader. Gets the pair around a moment; false while nothing has been published. Within an epoch times
    /// should not go backward: an earlier time than before gives the earliest frame still held, at blend 0.
    /// The reader goes over to a later epoch once two of its frames, or all that it has, are published; until
    /// then the pair stays the same, blend included. Epochs in between are skipped. The pair stays readable
    /// until the next call; frames before `pair.prev` may be recycled from here on. Wait-free: at most one
    /// walk over the ring (4 entries per slot); no allocation.
    bool pair_at(const MediaMoment& moment, FramePair& pair);
    /// Reader. The same in the reader's current epoch.
    bool pair_at(std::int64_t time_ns, FramePair& pair);

    /// Reader. Passes the pair of the last `pair_at` to the eye. Wait-free; does nothing without an eye.
    void show(std::int64_t tick);
    /// Eye, one thread. Returns what the reader showed last; null before the first. It stays readable until
    /// the next call, however long that takes. Wait-free, no allocation.
    const HeldPair* look();

private:
    struct Entry {
        std::int64_t number = 0, time_ns = 0;
        std::uint64_t epoch = 0;
        std::size_t slot = 0;
    };
    const Entry& entry(std::uint64_t sequence) const { return entries_[sequence % entries_.size()]; }
    TimedFrame timed_frame(std::uint64_t sequence) const;
    Result<void> check_later(std::int64_t number, std::int64_t time_ns) const;
    void append(std::int64_t number, std::int64_t time_ns, std::size_t slot);
    using Pins = std::array<std::uint64_t, 4>;
    Pins all_pins() const;
    bool go_over(std::uint64_t epoch, bool ended, std::uint64_t published, std::uint64_t& first);
    void hold(std::uint64_t prev, std::uint64_t next, double blend);

    // Entries are numbered from 0 without end; the ring holds entry n at n modulo its size. The reader owns
    // the entries in [reader_oldest_, published_) with the slots that they name, and the pinned slots; the
    // writer owns the rest.
    std::vector<std::unique_ptr<SurfaceFrame>> slots_;
    std::vector<Entry> entries_;
    // Writer only: the slot being built; for each slot, the reader_oldest_ from which on it can be recycled;
    // the epoch, and whether it has frames.
    std::optional<std::size_t> acquired_;
    std::vector<std::uint64_t> free_from_;
    std::uint64_t epoch_ = 0;
    bool epoch_has_frames_ = false;
    // Reader only: the pair that it holds; nullopt before its first look.
    std::optional<FramePair> held_;
    // Each on its own cache line, so that the sides do not slow each other.
    alignas(64) std::atomic<std::uint64_t> published_{0};      // stored by the writer
    alignas(64) std::atomic<std::uint64_t> reader_oldest_{0};  // stored by the reader, after pinned_
    std::atomic<std::uint64_t> pinned_{0};                     // by the reader: the slots of its pair
    // Three places for pairs on their way to the eye: one is the reader's, one the eye's, one lies between
    // them, and each side swaps its own for that. A pair's slots are pinned from before the reader passes it
    // on until its holder gives it up.
    const Eye eye_;
    std::array<HeldPair, 3> shown_;
    std::size_t readers_place_ = 0, eyes_place_ = 1;
    bool eye_has_seen_ = false;
    std::array<std::atomic<std::uint64_t>, 3> shown_pins_{};
    alignas(64) std::atomic<std::size_t> between_{2};    // the place, and whether it is new to the eye
    alignas(64) std::atomic<std::int64_t> newest_time_;  // stored by the writer
    std::atomic<std::uint64_t> ended_{0};                // by the writer: 1 + the epoch that has ended
};

}  // namespace touchable
