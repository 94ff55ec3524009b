#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace touchable {

/// How much may be on its way to a listener so that its link is never idle and nothing waits long in front of
/// it: the rate at which bytes arrive, times the way there and back, and a little more. What a link cannot
/// take is to be left out before it is sent, since datagrams that queue up are late or lost. No clock is
/// read: it is a function of what it is given.
class LinkRate {
public:
    /// Until it is known how quickly bytes arrive, and of the slowest link.
    static constexpr std::int64_t least_window_bytes = 1 << 16;
    static constexpr std::int64_t slice_ns = 250'000'000;

    /// What is known at this moment: bytes that have arrived so far, datagrams sent and lost so far, and the
    /// way there and back.
    struct Look {
        std::int64_t now_ns = 0, arrived_bytes = 0, datagrams = 0, lost = 0, rtt_ns = 0;
    };
    void look(const Look& look) {
        if (!newest_) first_in_slice_ = look;
        newest_ = look;
        shortest_in_slice_ns_ = std::min(shortest_in_slice_ns_, look.rtt_ns);
        const std::int64_t passed_ns = look.now_ns - first_in_slice_.now_ns;
        if (passed_ns < slice_ns) return;
        constexpr double ns_per_second = 1e9;
        const auto of_slice = [](std::int64_t now, std::int64_t then) {
            return std::max<std::int64_t>(now - then, 0);
        };
        Slice& slice = slices_[slice_count_++ % kept];
        slice.rate = static_cast<double>(of_slice(look.arrived_bytes, first_in_slice_.arrived_bytes)) *
                     ns_per_second / static_cast<double>(passed_ns);
        slice.datagrams = of_slice(look.datagrams, first_in_slice_.datagrams);
        slice.lost = of_slice(look.lost, first_in_slice_.lost);
        slice.rtt_ns = shortest_in_slice_ns_;
        first_in_slice_ = look;
        shortest_in_slice_ns_ = std::numeric_limits<std::int64_t>::max();
    }

    /// The most in a quarter of a second, of the last two seconds.
    std::int64_t bytes_per_second() const {
        double most = 0;
        for (std::size_t k = 0; k < std::min(slice_count_, recent); ++k)
            most = std::max(most, slices_[(slice_count_ - 1 - k) % kept].rate);
        return static_cast<std::int64_t>(most);
    }

    /// More may be handed over as long as less than this has not been acknowledged.
    std::int64_t window_bytes() const {
        // Acknowledgements are sent every 10 ms and looked at every 5; a thread may have to wait for a core.
        constexpr double slack_ns = 80e6, ns_per_second = 1e9;
        std::int64_t rtt_ns = newest_ ? newest_->rtt_ns : 0, datagrams = 0, lost = 0;
        for (std::size_t k = 0; k < std::min(slice_count_, kept); ++k) {
            const Slice& slice = slices_[(slice_count_ - 1 - k) % kept];
            rtt_ns = std::min(rtt_ns, slice.rtt_ns);
            if (k >= recent) continue;
            datagrams += slice.datagrams;
            lost += slice.lost;
        }
        // Acknowledgements stop at what is lost until it has been asked for and sent again.
        constexpr int loses_from = 200;  // one in so many
        const double ways = lost * loses_from > datagrams ? 3 : 1;
        const double seconds = (ways * static_cast<double>(rtt_ns) + slack_ns) / ns_per_second;
        const double bytes = static_cast<double>(bytes_per_second()) * seconds;
        constexpr double most_bytes = 64 << 20;
        return std::max(least_window_bytes, static_cast<std::int64_t>(std::min(bytes, most_bytes)));
    }

private:
    static constexpr std::size_t kept = 40, recent = 8;  // slices: 10 s, 2 s
    struct Slice {
        double rate = 0;  // bytes a second
        std::int64_t datagrams = 0, lost = 0, rtt_ns = 0;
    };
    std::array<Slice, kept> slices_{};  // a ring
    std::size_t slice_count_ = 0;
    std::optional<Look> newest_;
    Look first_in_slice_;
    std::int64_t shortest_in_slice_ns_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace touchable
