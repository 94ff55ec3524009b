#include "player/audio/gamepad_rumble.hpp"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "engine/base/start_thread.hpp"

namespace touchable {
namespace {

constexpr std::chrono::milliseconds between_looks(10);
constexpr std::uint32_t whole = 65535;

std::uint32_t packed(const Rumble& rumble) {
    const auto part = [](float share) { return static_cast<std::uint32_t>(std::lround(share * whole)); };
    return part(rumble.low) << 16U | part(rumble.high);
}
Rumble unpacked(std::uint32_t both) {
    return {static_cast<float>(both >> 16U) / whole, static_cast<float>(both & 0xFFFFU) / whole};
}

}  // namespace

struct GamepadRumble::Shared {
    std::atomic<std::uint32_t> newest{0};
    std::atomic<std::int64_t> ticks{0};
    mutable std::mutex mutex;
    std::condition_variable stop;
    bool stopping = false;
    std::string state = "rumble: looking for a gamepad";

    void say(std::string words) {
        const std::lock_guard lock(mutex);
        state = std::move(words);
    }
    /// After a moment, whether to go on.
    bool goes_on() {
        std::unique_lock lock(mutex);
        return !stop.wait_for(lock, between_looks, [this] { return stopping; });
    }
};

GamepadRumble::GamepadRumble(const Open& open) : shared_(std::make_shared<Shared>()) {
    const auto begun =
        start_thread(thread_, "gamepad", "of the gamepad", [shared = shared_, open] { run(*shared, open); });
    if (!begun.ok()) shared_->say("no rumble: " + begun.error().message);
}

GamepadRumble::~GamepadRumble() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->stopping = true;
    }
    shared_->stop.notify_all();
    if (thread_.joinable()) thread_.join();
}

void GamepadRumble::run(Shared& shared, const Open& open) {
    const auto pad = open();
    if (!pad.ok()) return shared.say("no rumble: " + pad.error().message);
    const auto begun = std::chrono::steady_clock::now();
    RumbleOrders orders;
    std::string name;
    do {
        const std::string now = (*pad)->look();
        if (now != std::exchange(name, now)) orders.forget();
        shared.say(name.empty() ? "rumble: no gamepad that has it" : "rumble: " + name);
        const std::int64_t ticks = shared.ticks.load(std::memory_order_acquire);
        const Rumble felt = unpacked(shared.newest.load(std::memory_order_relaxed));
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        if (const auto order = orders.at(seconds, felt, ticks))
            (*pad)->rumble(*order, *order == Rumble() ? 0 : RumbleOrders::lasts_ms);
    } while (shared.goes_on());
}

void GamepadRumble::take(const HeardTick& tick) {
    shared_->newest.store(packed(felt_.next(tick)), std::memory_order_relaxed);
    shared_->ticks.fetch_add(1, std::memory_order_release);
}

std::string GamepadRumble::state() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->state;
}

}  // namespace touchable
