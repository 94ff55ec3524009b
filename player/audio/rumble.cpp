// SPDX-License-Identifier: Apache-2.0
#include "player/audio/window_sound.hpp"

#include "engine/base/threads.hpp"

namespace touchable {
namespace {

constexpr std::chrono::milliseconds between_looks(10);

}  // namespace

std::optional<Rumble> RumbleOrders::at(double now_s, const Rumble& rumble, std::int64_t ticks) {
    if (ticks != ticks_) tick_s_ = now_s;
    ticks_ = ticks;
    const Rumble wanted = now_s - tick_s_ < tick_lasts_s ? rumble : Rumble();
    const bool goes_on = wanted == told_ && (wanted == Rumble() || now_s - told_s_ < renewed_s);
    if (goes_on) return std::nullopt;
    told_ = wanted;
    told_s_ = now_s;
    return wanted;
}

void GamepadRumble::say(std::string words) {
    const std::lock_guard lock(mutex_);
    state_ = std::move(words);
}

/// Waits a moment; returns whether to continue.
bool GamepadRumble::goes_on() {
    std::unique_lock lock(mutex_);
    return !stop_.wait_for(lock, between_looks, [this] { return stopping_; });
}

GamepadRumble::GamepadRumble(const Open& open) {
    const auto begun = start_thread(thread_, "gamepad", "of the gamepad", [this, open] { run(open); });
    if (!begun) say("no rumble: " + begun.error().message);
}

void GamepadRumble::run(const Open& open) {
    const auto pad = open();
    if (!pad) return say("no rumble: " + pad.error().message);
    const auto begun = std::chrono::steady_clock::now();
    RumbleOrders orders;
    std::string name;
    do {
        const std::string now = (*pad)->look();
        if (now != std::exchange(name, now)) orders.forget();
        say(name.empty() ? "rumble: no gamepad that has it" : "rumble: " + name);
        const std::int64_t ticks = ticks_.load(std::memory_order_acquire);
        const Rumble felt = newest_.load(std::memory_order_relaxed);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        if (const auto order = orders.at(seconds, felt, ticks))
            (*pad)->rumble(*order, *order == Rumble() ? 0 : RumbleOrders::lasts_ms);
    } while (goes_on());
}

void GamepadRumble::consume(const HeardTick& tick) {
    newest_.store(felt_.next(tick), std::memory_order_relaxed);
    ticks_.fetch_add(1, std::memory_order_release);
}

std::string GamepadRumble::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

}  // namespace touchable
