#pragma once

// When the framesets of a live stream are shown: of those that come one by one (JitterBuffer), and of those
// that come in segments (SegmentPace). Both read no clock: they are functions of what they are given.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace touchable {

/// When framesets of a sender are shown, so that most of them are there in time, and none waits longer than
/// it must. The shortest way of the last seconds tells how the sender's clock stands to ours, and is followed
/// as they drift apart. How much longer others take is their jitter: all wait so long as nearly all of the
/// last ones took (97 of 100). That rises at once and falls slowly, up to a bound. A clock that jumps,
/// forward, back or by years, begins anew with the frameset that says so; of one that stands still every
/// frameset counts from its arrival.
class JitterBuffer {
public:
    /// The longest that a frameset waits for others' sake, ns.
    explicit JitterBuffer(std::int64_t latency_ns) : latency_ns_(latency_ns) {}

    struct Moments {
        std::int64_t taken_ns = 0;  ///< as it would have come by the shortest way; at most `most_way_ns` ago
        std::int64_t shown_ns = 0;  ///< never before that of the frameset before
    };
    /// The moments of the next frameset, by our clock. `sent_ns`: by the sender's (0: not known);
    /// `arrived_ns`: by ours, ever later.
    Moments add(std::int64_t sent_ns, std::int64_t arrived_ns);
    /// The sender was connected to anew.
    void restart();
    /// The time that framesets wait for others' sake now.
    std::int64_t delay_ns() const { return delay_ns_; }

    static constexpr std::int64_t most_way_ns = 1'000'000'000;

private:
    static constexpr std::size_t buckets = 20, kept = 128;
    static constexpr std::int64_t bucket_ns = 500'000'000;
    struct Shortest {
        std::int64_t bucket = 0, way_ns = 0;
    };
    std::int64_t shortest_way(std::int64_t way_ns, std::int64_t arrived_ns);
    void adapt(std::int64_t jitter_ns, std::int64_t arrived_ns);

    const std::int64_t latency_ns_;
    std::array<std::optional<Shortest>, buckets> shortest_{};
    std::array<std::int64_t, kept> jitters_{};  // a ring
    std::size_t jitter_count_ = 0;
    std::int64_t delay_ns_ = 0, last_sent_ns_ = 0, last_arrived_ns_ = 0, last_shown_ns_ = 0;
};

/// When framesets are shown that come many at a time, as in segments of HTTP Live Streaming: as far apart as
/// they were taken, the first one `margin_ns` after it came. Where one comes too late, all that follow are so
/// much later; where they run far ahead, or the sender's clock jumps, it begins anew.
class SegmentPace {
public:
    explicit SegmentPace(std::int64_t margin_ns) : margin_ns_(margin_ns) {}
    /// As JitterBuffer::add.
    JitterBuffer::Moments add(std::int64_t sent_ns, std::int64_t arrived_ns);

private:
    const std::int64_t margin_ns_;
    std::optional<std::int64_t> apart_ns_;  // our clock is so far ahead of the sender's
};

}  // namespace touchable
