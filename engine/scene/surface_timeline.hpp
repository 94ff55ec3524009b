#pragma once

// The ring of published frames between the thread that builds and the haptic thread.
//
// The builder takes a free slot, fills its SurfaceFrame and publishes it at a timestamp; the haptic thread
// asks for the pair of frames around a moment and holds it, pinned, while it reads. Neither waits for the
// other, and nothing is allocated after the start. A moment has an epoch: a seek, a loop's way back or
// another clip begins one, and a pair never reaches across (docs/mechanisms.md, Time). A third thread may
// look at what the hand holds, to draw it.
//
// One thread builds, one reads, one looks.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A published frame and its moment.
struct TimedFrame {
    std::int64_t number = -1;  ///< of the clip's frame
    std::int64_t time_ns = 0;
    const SurfaceFrame* frame = nullptr;
};

/// A moment on a clip's clock. Times go forward within an epoch; from one to another they may go anywhere.
struct MediaMoment {
    std::uint64_t epoch = 0;
    std::int64_t time_ns = 0;
    std::int64_t start_ns = 0;  ///< where the epoch begins
    bool operator==(const MediaMoment&) const = default;
};

/// The frames around a moment. `next` equals `prev` before the first, from the last on, and while the
/// producer is late; then blend is 0.
struct FramePair {
    TimedFrame prev, next;
    double blend = 0;  ///< 0 at prev's time, towards 1 at next's
    /// Of the clip's clock: another one has nothing to do with the frames before, whatever its times.
    std::uint64_t epoch = 0;
};

/// What the reader held in a tick.
struct HeldPair {
    FramePair pair;
    std::int64_t tick = 0;
};

/// A ring of published SurfaceFrames between one writer (the surface thread) and one reader (the haptic
/// thread). The reader never waits; the writer's slots are recycled only once the reader has moved past them.
/// An eye (whoever draws) may look at what the reader holds; neither of the two waits for it. Nothing here
/// locks, waits or retries: each side reads what the others last stored and works with that.
class SurfaceTimeline {
public:
    /// `slots`: frames that exist at once, at least 3 (the reader's pair, and one being built); 4 where
    /// epochs begin (the pair that it holds, and the one that it goes over to);
    /// with an eye 2 more.
    enum class Eye { none, one };
    explicit SurfaceTimeline(int slots, Eye eye = Eye::none);
    SurfaceTimeline(const SurfaceTimeline&) = delete;
    SurfaceTimeline& operator=(const SurfaceTimeline&) = delete;

    /// Writer. A slot to build into, or nullptr while the reader still needs all of them (or all entries).
    /// The slot stays the writer's until it is published; asking again returns the same one. It still holds
    /// the frame it was last published with. Wait-free: one look at each slot.
    SurfaceFrame* acquire();
    /// Writer. Publishes the acquired slot; there is always an entry for it. A time not later than the newest
    /// one's is refused, and the slot kept. Wait-free; only a refusal allocates, for its message.
    Result<void> publish(std::int64_t number, std::int64_t time_ns);
    /// Writer. Publishes the newest frame once more, at a later time: nothing changed. Refused while the ring
    /// of entries is full (false), with a time not later, or before the first frame of the epoch (errors).
    /// Wait-free.
    Result<bool> republish(std::int64_t number, std::int64_t time_ns);
    /// Writer. What is published from now on is of this epoch, a later one than before, and its times may be
    /// any. Wait-free.
    void begin_epoch(std::uint64_t epoch);
    /// Writer. The epoch has no more frames than are published. Wait-free.
    void end_epoch();

    /// Any thread. Time of the newest epoch's newest frame; INT64_MIN before the first. A reader that has
    /// seen it finds that frame. Wait-free.
    std::int64_t newest_time() const;

    /// Reader. The pair around a moment; false while nothing has been published. Within an epoch times should
    /// not go backward: an earlier time than before gives the earliest frame still held, at blend 0. A later
    /// epoch than before is gone over to once two of its frames are published, or all that it has; until then
    /// the pair stays the one that it was, blend and all. Epochs in between are passed over. The pair stays
    /// readable until the next call; frames before `pair.prev` may be recycled from here on. Wait-free: at
    /// most one walk over the ring (4 entries per slot); no allocation.
    bool pair_at(const MediaMoment& moment, FramePair& pair);
    /// Reader. Of the epoch that it is in.
    bool pair_at(std::int64_t time_ns, FramePair& pair);

    /// Reader. Lets the eye have what the last `pair_at` gave. Wait-free; does nothing where there is no eye.
    void show(std::int64_t tick);
    /// Eye, one thread. What the reader showed last; nothing before the first. It stays readable until the
    /// next call, however long that takes. Wait-free, no allocation.
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

    // Entries are numbered from 0 without end; the ring holds entry n at n modulo its size. Those in
    // [reader_oldest_, published_) and the slots they name are the reader's, and so are the pinned slots; all
    // else is the writer's.
    std::vector<std::unique_ptr<SurfaceFrame>> slots_;
    std::vector<Entry> entries_;
    // Writer only: the slot being built, for each slot where reader_oldest_ must be to recycle it, and the
    // epoch with what was published of it.
    std::optional<std::size_t> acquired_;
    std::vector<std::uint64_t> free_from_;
    std::uint64_t epoch_ = 0;
    bool epoch_has_frames_ = false;
    // Reader only: what it holds; nothing before its first look.
    std::optional<FramePair> held_;
    // Each on its own cache line, so that the sides do not slow each other.
    alignas(64) std::atomic<std::uint64_t> published_{0};      // stored by the writer
    alignas(64) std::atomic<std::uint64_t> reader_oldest_{0};  // stored by the reader, after pinned_
    std::atomic<std::uint64_t> pinned_{0};                     // by the reader: the slots of its pair
    // Three places for pairs on their way to the eye: one is the reader's, one the eye's, one lies between
    // them, and each swaps its own for that. Pins stand beside a pair from before the reader puts it there
    // until whoever has it gives it up.
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
