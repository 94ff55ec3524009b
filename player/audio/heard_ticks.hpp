#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "player/audio/heard_sound.hpp"

namespace touchable {

/// Ticks on their way from a session's thread to a sound device's, where they become sound. Neither waits for
/// the other, and neither allocates. Their clocks differ: where the device lags, ticks are merged; where it
/// is ahead, the last one goes on for a little, and then fades.
class HeardTicks {
public:
    explicit HeardTicks(std::shared_ptr<ClipSound> clip) : clip_(std::move(clip)) {}
    /// What is said lives as long as this. Before anything else.
    void keep(std::vector<std::shared_ptr<const SpokenSound>> sounds) { spoken_ = std::move(sounds); }
    /// The session's thread. What finds no room is not heard.
    void push(const HeardTick& tick);
    /// The device's thread: the next samples. What came before the first call is not heard.
    void fill(std::span<StereoSample> samples);

    static constexpr std::size_t most_waiting = 256;
    /// More than what a call needs waits for the next: sessions give ticks a few at a time.
    static constexpr std::uint64_t slack = 12;
    static constexpr int longest_bridge = 20;  ///< ticks that the last one goes on for

private:
    HeardTick next(std::uint64_t wanted);

    std::array<HeardTick, most_waiting> ticks_{};
    alignas(64) std::atomic<std::uint64_t> pushed_{0};
    alignas(64) std::atomic<std::uint64_t> popped_{0};
    // The device's.
    alignas(64) HeardSound sound_;
    std::shared_ptr<ClipSound> clip_;
    std::vector<std::shared_ptr<const SpokenSound>> spoken_;
    ContactSound::Samples samples_{};
    std::size_t played_ = ContactSound::samples_per_tick;  // of `samples_`
    HeardTick last_;
    int bridged_ = longest_bridge;
    bool begun_ = false;
};

}  // namespace touchable
