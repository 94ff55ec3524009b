#pragma once

#include <cstdint>
#include <optional>

#include "engine/stream/jitter_buffer.hpp"

namespace touchable {

/// When framesets are shown that come many at a time, as in segments of HTTP Live Streaming: as far apart as
/// they were taken, the first one `margin_ns` after it came. Where one comes too late, all that follow are so
/// much later; where they run far ahead, or the sender's clock jumps, it begins anew.
class SegmentPace {
public:
    explicit SegmentPace(std::int64_t margin_ns) : margin_ns_(margin_ns) {}
    /// As JitterBuffer::add.
    JitterBuffer::Moments add(std::int64_t sent_ns, std::int64_t arrived_ns) {
        constexpr std::int64_t most_ahead_ns = 60'000'000'000, most_known = std::int64_t{1} << 61U;
        if (sent_ns <= 0 || sent_ns >= most_known) return {arrived_ns, arrived_ns};
        if (!apart_ns_) apart_ns_ = arrived_ns + margin_ns_ - sent_ns;
        std::int64_t shown_ns = sent_ns + *apart_ns_;
        if (shown_ns < arrived_ns || shown_ns > arrived_ns + most_ahead_ns) {
            apart_ns_ = arrived_ns - sent_ns;
            shown_ns = arrived_ns;
        }
        return {shown_ns, shown_ns};
    }

private:
    const std::int64_t margin_ns_;
    std::optional<std::int64_t> apart_ns_;  // our clock is so far ahead of the sender's
};

}  // namespace touchable
