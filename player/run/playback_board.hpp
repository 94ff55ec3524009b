#pragma once

#include <atomic>
#include <cstdint>

#include "player/run/playback_clock.hpp"

namespace touchable {

/// What the clip's clock is doing, for other threads than the haptic one: each sees one tick's whole state.
/// The writer waits for nobody; a reader looks again where it was written to while it read.
class PlaybackBoard {
public:
    /// Haptic thread; before it begins, whoever starts it.
    void set(const PlaybackState& state) {
        const std::uint64_t writes = writes_.load(std::memory_order_relaxed);
        writes_.store(writes + 1, std::memory_order_relaxed);
        // With release: whoever reads one of them sees that they are being written.
        constexpr auto release = std::memory_order_release;
        epoch_.store(state.moment.epoch, release);
        time_ns_.store(state.moment.time_ns, release);
        start_ns_.store(state.moment.start_ns, release);
        playing_.store(state.playing, release);
        rate_.store(state.rate, release);
        loops_.store(state.loops, release);
        loop_begin_ns_.store(state.loop_begin_ns, release);
        loop_end_ns_.store(state.loop_end_ns, release);
        writes_.store(writes + 2, release);
    }

    PlaybackState read() const {
        constexpr auto acquire = std::memory_order_acquire;
        while (true) {
            const std::uint64_t writes = writes_.load(acquire);
            PlaybackState state;
            state.moment = {epoch_.load(acquire), time_ns_.load(acquire), start_ns_.load(acquire)};
            state.playing = playing_.load(acquire);
            state.rate = rate_.load(acquire);
            state.loops = loops_.load(acquire);
            state.loop_begin_ns = loop_begin_ns_.load(acquire);
            state.loop_end_ns = loop_end_ns_.load(acquire);
            if (writes % 2 == 0 && writes_.load(std::memory_order_relaxed) == writes) return state;
        }
    }
    MediaMoment moment() const { return read().moment; }

private:
    alignas(64) std::atomic<std::uint64_t> writes_{0};  // twice the times it was written; odd: it is being
    std::atomic<std::uint64_t> epoch_{0};
    std::atomic<std::int64_t> time_ns_{0}, start_ns_{0}, rate_{1000}, loop_begin_ns_{0}, loop_end_ns_{0};
    std::atomic<bool> playing_{true}, loops_{false};
};

}  // namespace touchable
