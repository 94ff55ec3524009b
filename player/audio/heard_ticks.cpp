#include "player/audio/heard_ticks.hpp"

#include <algorithm>

namespace touchable {

void HeardTicks::push(const HeardTick& tick) {
    const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
    if (at - popped_.load(std::memory_order_acquire) >= ticks_.size()) return;
    ticks_[at % ticks_.size()] = tick;
    pushed_.store(at + 1, std::memory_order_release);
}

/// The tick to be heard now, where `wanted` more are to follow in this call.
HeardTick HeardTicks::next(std::uint64_t wanted) {
    std::uint64_t at = popped_.load(std::memory_order_relaxed);
    const std::uint64_t end = pushed_.load(std::memory_order_acquire);
    if (at == end) {
        return ++bridged_ <= longest_bridge ? going_on(last_) : silence_after(last_);
    }
    HeardTick tick = ticks_[at++ % ticks_.size()];
    while (end - at > wanted + slack) tick = merged(tick, ticks_[at++ % ticks_.size()]);
    popped_.store(at, std::memory_order_release);
    last_ = tick;
    bridged_ = 0;
    return tick;
}

void HeardTicks::fill(std::span<StereoSample> samples) {
    if (!begun_) popped_.store(pushed_.load(std::memory_order_acquire), std::memory_order_release);
    begun_ = true;
    for (std::size_t k = 0; k < samples.size(); ++k) {
        if (played_ == samples_.size()) {
            sound_.render(next((samples.size() - k) / samples_.size()), *clip_, samples_);
            played_ = 0;
        }
        samples[k] = samples_[played_++];
    }
}

}  // namespace touchable
