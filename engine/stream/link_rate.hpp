#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

namespace touchable {

/// How much may be on its way to a listener so that its link is never idle and nothing waits long in front of
/// it: the rate at which bytes arrive, times the way there and back, and a little more. What a link cannot
/// take is to be left out before it is sent, since datagrams that queue up are late or lost. No clock is
/// read: it is a function of what it is given.
class LinkRate {
public:
    /// Of the slowest link; and before it is known how quickly bytes arrive.
    static constexpr std::int64_t least_window_bytes = 1 << 16, first_window_bytes = 1 << 18;
    static constexpr std::int64_t slice_ns = 250'000'000;

    /// What is known at this moment: bytes that have arrived so far, datagrams sent and lost so far, the way
    /// there and back (0: not known), and whether more would be handed over if the window were larger.
    struct Look {
        std::int64_t now_ns = 0, arrived_bytes = 0, datagrams = 0, lost = 0, rtt_ns = 0;
        bool is_full = false;
    };
    void look(const Look& look) {
        if (!first_in_slice_) first_in_slice_ = look;
        if (look.rtt_ns > 0) {
            shortest_ns_ = shortest_ns_ > 0 ? std::min(shortest_ns_, look.rtt_ns) : look.rtt_ns;
            slice_.rtt_ns = std::min(slice_.rtt_ns, look.rtt_ns);
        }
        slice_.is_full = slice_.is_full || look.is_full;
        const std::int64_t passed_ns = look.now_ns - first_in_slice_->now_ns;
        if (passed_ns < slice_ns) return;
        const auto more = [](std::int64_t now, std::int64_t then) {
            return std::max<std::int64_t>(now - then, 0);
        };
        constexpr double ns_per_second = 1e9;
        slice_.rate = static_cast<double>(more(look.arrived_bytes, first_in_slice_->arrived_bytes)) *
                      ns_per_second / static_cast<double>(passed_ns);
        slice_.datagrams = more(look.datagrams, first_in_slice_->datagrams);
        slice_.lost = more(look.lost, first_in_slice_->lost);
        slices_[slice_count_++ % recent] = std::exchange(slice_, Slice{});
        first_in_slice_ = look;
        grow();
        forget_shortest();
    }

    /// What the link takes is not known yet. Twice what fits on the way may be on it, until the rate no
    /// longer rises by a quarter, or bytes queue up, or all that there is has fitted for a while.
    bool is_growing() const { return is_growing_; }

    /// That of the last second, or of the one before if it was more. What was lost and comes at last is
    /// acknowledged together with all that is behind it, so shorter times would tell of more than arrives.
    std::int64_t bytes_per_second() const {
        double most = 0;
        for (const std::size_t before : {std::size_t{0}, recent / 2}) {
            const std::size_t there = slice_count_ - std::min(slice_count_, before);
            const std::size_t slices = std::min(there, recent / 2);
            double sum = 0;
            for (std::size_t k = 0; k < slices; ++k) sum += slices_[(there - 1 - k) % recent].rate;
            if (slices > 0) most = std::max(most, sum / static_cast<double>(slices));
        }
        return static_cast<std::int64_t>(most);
    }

    /// More may be handed over as long as less than this has not been acknowledged.
    std::int64_t window_bytes() const {
        constexpr std::size_t first_slices = 4;
        // Acknowledgements are sent every 10 ms and looked at every 5; a thread may have to wait for a core.
        // On a long way the rate has to be able to grow by a quarter.
        constexpr double least_slack_ns = 80e6, ns_per_second = 1e9;
        const auto way_ns = static_cast<double>(shortest_ns_);
        const double slack_ns = std::max(least_slack_ns, way_ns / 4);
        std::int64_t datagrams = 0, lost = 0;
        for (const Slice& slice : slices_) {
            datagrams += slice.datagrams;
            lost += slice.lost;
        }
        // Acknowledgements stop at what is lost until it has been asked for and sent again. Of the hundreds
        // of datagrams on their way some are lost once more as they are sent again.
        constexpr int loses_from = 200;  // one in so many
        const double ways = lost * loses_from > datagrams ? 6 : 1;
        const double seconds = ((ways + (is_growing_ ? 1 : 0)) * way_ns + slack_ns) / ns_per_second;
        const double bytes = static_cast<double>(bytes_per_second()) * seconds;
        constexpr double most_bytes = 64 << 20;
        return std::max(
            slice_count_ < first_slices || shortest_ns_ == 0 ? first_window_bytes : least_window_bytes,
            static_cast<std::int64_t>(std::min(bytes, most_bytes)));
    }

private:
    static constexpr std::size_t recent = 8;
    struct Slice {
        double rate = 0;  // bytes a second
        std::int64_t datagrams = 0, lost = 0, rtt_ns = std::numeric_limits<std::int64_t>::max();
        bool is_full = false;
    };
    void grow() {
        if (!is_growing_ || shortest_ns_ == 0) return;
        constexpr double grows_by = 1.25;
        constexpr std::int64_t queue_ns = 100'000'000, least_in_vain_ns = 1'000'000'000, ways_in_vain = 3,
                               fits_for_ns = 4'000'000'000;
        const Slice& newest = slices_[(slice_count_ - 1) % recent];
        const auto rate = static_cast<double>(bytes_per_second());
        if (rate > grows_by * fastest_) {
            fastest_ = rate;
            in_vain_ns_ = 0;
        } else if (newest.is_full) {
            in_vain_ns_ += slice_ns;
        }
        fits_ns_ = newest.is_full ? 0 : fits_ns_ + slice_ns;
        const bool has_queue = newest.rtt_ns < std::numeric_limits<std::int64_t>::max() &&
                               newest.rtt_ns > 2 * shortest_ns_ + queue_ns;
        is_growing_ = !has_queue && fits_ns_ < fits_for_ns &&
                      in_vain_ns_ < std::max(least_in_vain_ns, ways_in_vain * shortest_ns_);
    }
    /// The way there and back is measured anew while nothing of ours waits in front of the link. While the
    /// window is full something does, and to believe in that would widen the window again and again.
    void forget_shortest() {
        if (slice_count_ < recent) return;
        std::int64_t shortest_ns = std::numeric_limits<std::int64_t>::max();
        for (const Slice& slice : slices_) {
            if (slice.is_full) return;
            shortest_ns = std::min(shortest_ns, slice.rtt_ns);
        }
        if (shortest_ns < std::numeric_limits<std::int64_t>::max()) shortest_ns_ = shortest_ns;
    }

    std::array<Slice, recent> slices_{};  // a ring
    std::size_t slice_count_ = 0;
    Slice slice_;  // that has not ended
    std::optional<Look> first_in_slice_;
    std::int64_t shortest_ns_ = 0;  // way there and back
    bool is_growing_ = true;
    double fastest_ = 0;           // bytes a second, while it grows
    std::int64_t in_vain_ns_ = 0;  // for which the window was full, and the rate did not grow
    std::int64_t fits_ns_ = 0;     // for which the window was not full
};

}  // namespace touchable
