#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace touchable {

/// When frames are shown. Evenly: frame n is at floor(n 1e9 den / num) ns. Or each at a time of its own (a
/// variable rate): then num / den is the mean, by which frames beyond the last known one follow it.
struct FrameRate {
    std::int64_t num = 30, den = 1;
    std::shared_ptr<const std::vector<std::int64_t>> own_times{};  ///< ns, from 0 up; null: evenly

    std::int64_t time_ns(std::int64_t frame) const;     ///< exact; no overflow for frame < 2^40
    std::int64_t frame_at(std::int64_t time_ns) const;  ///< the last one that is not later; exact likewise
    std::int64_t nearest(std::int64_t time_ns) const;   ///< the frame that is, the earlier of two
    double per_second() const { return static_cast<double>(num) / static_cast<double>(den); }
};
/// Closer frames are told apart by no container's milliseconds, and by no tick.
inline constexpr std::int64_t shortest_frame_ns = 1'000'000;
/// Of frames at times of their own, ns; the first is time 0. Nothing where there are fewer than two, where
/// one is less than `shortest_frame_ns` after the one before, or where all last longer than 126 years.
std::optional<FrameRate> rate_of_own_times(std::vector<std::int64_t> times_ns);

}  // namespace touchable
