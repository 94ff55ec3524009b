#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "engine/stream/stream_muxer.hpp"

namespace touchable {

/// How far behind the newest frameset a listener may be, before whole framesets are left out for it.
struct StreamBounds {
    std::int64_t framesets = 30;
    std::size_t bytes = std::size_t{64} << 20U;
};

/// What of a stream is there for its listeners: its header and the newest framesets, which all of them share.
/// It keeps as many as the bounds allow, and always those from the newest key on. All of it from any thread,
/// but each cursor is one thread's.
class StreamRing {
public:
    using Block = std::shared_ptr<const StreamBlock>;
    using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;

    /// Where one listener is.
    class Cursor {
    public:
        std::int64_t dropped() const { return dropped_; }  ///< framesets that were left out for it

    private:
        friend class StreamRing;
        std::int64_t next_ = 0;  // counted from the stream's first block
        std::int64_t dropped_ = 0;
    };

    explicit StreamRing(const StreamBounds& bounds = {}) : bounds_(bounds) {}
    /// `wake` is called after whatever changes, by who changed it. Before others use the ring.
    void watch(std::function<void()> wake) { watchers_.push_back(std::move(wake)); }

    /// What every listener is given first, and what says nothing (StreamMuxer); before the first block.
    void begin(std::span<const std::uint8_t> header, std::span<const std::uint8_t> padding = {});
    void add(StreamBlock block);
    /// No block comes any more.
    void end();

    /// A listener that comes now begins with the newest key; where nothing is there yet, with the first
    /// block.
    Cursor join() const;
    /// Null before `begin`.
    Bytes header() const;
    /// Empty before `begin`.
    std::vector<std::uint8_t> padding() const;
    /// The listener's next frameset: the one after the last, or where it is too far behind the newest key.
    /// Null: there is none yet.
    Block next(Cursor& cursor) const;
    /// The same; waits for one so long.
    Block wait_next(Cursor& cursor, std::chrono::milliseconds longest) const;
    /// Whether `next` would give one.
    bool has_next(const Cursor& cursor) const;
    /// The listener's next frameset is the newest key, and those before it are left out. False where that
    /// would leave nothing out.
    bool go_to_newest_key(Cursor& cursor) const;
    /// Whether `next` has nothing more for it.
    bool is_over(const Cursor& cursor) const;
    /// Whether no block comes any more, for whoever has not joined.
    bool is_ended() const;

private:
    struct Kept {
        Block block;
        std::size_t bytes_before;  // of the stream, up to this block
    };
    Block take(Cursor& cursor) const;
    std::int64_t end_of_kept() const { return first_ + std::ssize(kept_); }
    void changed();

    const StreamBounds bounds_;
    std::vector<std::function<void()>> watchers_;
    mutable std::mutex mutex_;
    mutable std::condition_variable there_is_more_;
    // Guarded by mutex_.
    Bytes header_;
    std::vector<std::uint8_t> padding_;
    std::deque<Kept> kept_;
    std::int64_t first_ = 0;  // the number of kept_'s first
    std::int64_t newest_key_ = 0;
    std::size_t bytes_ = 0;  // of all blocks so far
    bool is_over_ = false;
};

}  // namespace touchable
