#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace touchable {

/// When frames were taken, by a sender's clock of which nobody knows when it began: what it says of the time
/// between frames is believed, and of those that came soonest after they were taken their arrival. A clock
/// that jumps, stands still or goes backwards begins anew with a frame's arrival; one that goes slower or
/// faster is followed.
class SenderClock {
public:
    /// Of a frame that `sent_ns` is said of (0: nothing is), at the time of std::chrono::steady_clock, like
    /// its arrival: no later than that, and at most 0.1 s before.
    std::int64_t taken_at(std::int64_t sent_ns, std::int64_t arrived_ns) {
        constexpr std::int64_t longest_way = 100'000'000, slower = 1000;  // a thousandth
        constexpr std::int64_t most_known = std::int64_t{1} << 62U;
        const bool is_known = sent_ns > 0 && sent_ns < most_known;
        if (!is_known || !last_ || sent_ns <= last_->sent_ns)
            apart_ns_ = arrived_ns - (is_known ? sent_ns : 0);
        else
            apart_ns_ = std::min(apart_ns_ + (arrived_ns - last_->arrived_ns) / slower, arrived_ns - sent_ns);
        if (is_known && arrived_ns - sent_ns - apart_ns_ > longest_way) apart_ns_ = arrived_ns - sent_ns;
        if (!is_known) {
            last_.reset();
            return arrived_ns;
        }
        last_ = Moment{sent_ns, arrived_ns};
        return sent_ns + apart_ns_;
    }

private:
    struct Moment {
        std::int64_t sent_ns = 0, arrived_ns = 0;
    };
    std::optional<Moment> last_;
    std::int64_t apart_ns_ = 0;  // this machine's clock is so far ahead of the sender's
};

}  // namespace touchable
