// When a sender's framesets were taken, and when they are shown.

#include <algorithm>

#include "engine/base/same_bits.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

/// ns; later times of a sender's clock count as unknown.
constexpr std::int64_t latest_known_ns = std::int64_t{1} << 61U;

}  // namespace

void JitterBuffer::restart() {
    shortest_ = {};
    last_sent_ns_ = 0;
}

/// The shortest transit time of the last ten seconds.
std::int64_t JitterBuffer::shortest_way(std::int64_t way_ns, std::int64_t arrived_ns) {
    const std::int64_t bucket = arrived_ns / bucket_ns;
    auto& now = shortest_[static_cast<std::size_t>(bucket) % buckets];
    if (!now || now->bucket != bucket) now = Shortest{bucket, way_ns};
    now->way_ns = std::min(now->way_ns, way_ns);
    std::int64_t shortest = now->way_ns;
    for (const auto& one : shortest_)
        if (one && bucket - one->bucket < static_cast<std::int64_t>(buckets))
            shortest = std::min(shortest, one->way_ns);
    return shortest;
}

void JitterBuffer::adapt(std::int64_t jitter_ns, std::int64_t arrived_ns) {
    constexpr std::int64_t fall_ns = 8'000'000'000;  // time in which a delay falls to about a third
    jitters_[jitter_count_++ % kept] = jitter_ns;
    std::vector<std::int64_t> all(
        jitters_.begin(), jitters_.begin() + static_cast<std::ptrdiff_t>(std::min(jitter_count_, kept)));
    const std::int64_t high = sorted_element(all, (all.size() - 1) * 97 / 100),
                       wanted = std::clamp<std::int64_t>(high, 0, latency_ns_);
    const std::int64_t passed = std::clamp<std::int64_t>(arrived_ns - last_arrived_ns_, 0, fall_ns);
    if (wanted >= delay_ns_)
        delay_ns_ = wanted;
    else
        delay_ns_ -= static_cast<std::int64_t>(static_cast<double>(delay_ns_ - wanted) *
                                               static_cast<double>(passed) / static_cast<double>(fall_ns));
}

JitterBuffer::Moments JitterBuffer::add(std::int64_t sent_ns, std::int64_t arrived_ns) {
    const bool goes_on = sent_ns > 0 && sent_ns < latest_known_ns && sent_ns > last_sent_ns_;
    const bool is_first = last_sent_ns_ == 0;
    Moments moments{arrived_ns, arrived_ns};
    if (goes_on) {
        const std::int64_t way_ns = arrived_ns - sent_ns;
        std::int64_t jitter_ns = way_ns - shortest_way(way_ns, arrived_ns);
        if (jitter_ns > longest_way_ns_) {  // the sender's clock went back, or all was held up
            shortest_ = {};
            (void)shortest_way(way_ns, arrived_ns);
            jitter_ns = 0;
        } else if (!is_first) {
            adapt(jitter_ns, arrived_ns);
        }
        moments.taken_ns = arrived_ns - jitter_ns;
        moments.shown_ns = std::max(arrived_ns, moments.taken_ns + delay_ns_);
    } else {
        shortest_ = {};
        if (sent_ns > 0 && sent_ns < latest_known_ns) (void)shortest_way(arrived_ns - sent_ns, arrived_ns);
    }
    last_sent_ns_ = sent_ns > 0 && sent_ns < latest_known_ns ? sent_ns : 0;
    last_arrived_ns_ = arrived_ns;
    moments.shown_ns = std::max(moments.shown_ns, last_shown_ns_);
    last_shown_ns_ = moments.shown_ns;
    return moments;
}

JitterBuffer::Moments SegmentPace::add(std::int64_t sent_ns, std::int64_t arrived_ns) {
    constexpr std::int64_t most_ahead_ns = 60'000'000'000;
    if (sent_ns <= 0 || sent_ns >= latest_known_ns) return {arrived_ns, arrived_ns};
    if (!apart_ns_) apart_ns_ = arrived_ns + margin_ns_ - sent_ns;
    std::int64_t shown_ns = sent_ns + *apart_ns_;
    if (shown_ns < arrived_ns || shown_ns > arrived_ns + most_ahead_ns) {
        apart_ns_ = arrived_ns - sent_ns;
        shown_ns = arrived_ns;
    }
    return {shown_ns, shown_ns};
}

}  // namespace touchable
