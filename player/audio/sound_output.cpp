#include "player/audio/sound_output.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include "engine/start_thread.hpp"
#include "player/audio/sound_device.hpp"

namespace touchable {

struct SoundOutput::Shared {
    std::shared_ptr<HeardTicks> ticks;
    std::atomic<bool> stopping{false};
    mutable std::mutex mutex;
    std::condition_variable ended_now;
    std::string state = "sound is being opened";
    bool ended = false;

    void say(std::string words) {
        const std::lock_guard lock(mutex);
        state = std::move(words);
    }
    void end() {
        const std::lock_guard lock(mutex);
        ended = true;
        ended_now.notify_all();
    }
};

namespace {

using Clock = std::chrono::steady_clock;

constexpr int block = 240;  // 5 ms
constexpr std::chrono::milliseconds patience(100);

/// Samples until somebody asks to stop. Some outputs of ALSA's take all at once, as fast as it comes: they
/// get a hundredth more than the time that has passed, which is more than a real one's clock goes too fast.
Result<void> play(SoundOutput::Shared& shared, SoundDevice& device) {
    std::vector<StereoSample> samples(block);
    const auto begun = Clock::now();
    double written = 0;
    while (!shared.stopping.load(std::memory_order_relaxed)) {
        const double passed = std::chrono::duration<double>(Clock::now() - begun).count();
        if (written > 1.01 * ContactSound::rate * passed + SoundDevice::buffer) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
            continue;
        }
        const auto ready = device.wait_for(block, patience);
        if (!ready.ok()) return ready.error();
        if (!*ready) continue;
        shared.ticks->fill(samples);
        if (auto given = device.write(samples); !given.ok()) return given;
        written += block;
    }
    return {};
}

void open_and_play(SoundOutput::Shared& shared) {
    auto device = SoundDevice::open();
    if (!device.ok()) return shared.say("no sound: " + device.error().message);
    shared.say("sound on");
    if (auto played = play(shared, **device); !played.ok())
        shared.say("no sound any more: " + played.error().message);
}

}  // namespace

SoundOutput::SoundOutput(std::shared_ptr<HeardTicks> ticks) : shared_(std::make_shared<Shared>()) {
    shared_->ticks = std::move(ticks);
    const auto begun = start_thread(thread_, "sound-output", "of the sound", [shared = shared_] {
        open_and_play(*shared);
        shared->end();
    });
    if (!begun.ok()) shared_->say("no sound: " + begun.error().message);
}

SoundOutput::~SoundOutput() {
    if (!thread_.joinable()) return;
    shared_->stopping.store(true, std::memory_order_relaxed);
    std::unique_lock lock(shared_->mutex);
    const bool ended =
        shared_->ended_now.wait_for(lock, std::chrono::seconds(1), [this] { return shared_->ended; });
    lock.unlock();
    if (ended)
        thread_.join();
    else
        thread_.detach();
}

std::string SoundOutput::state() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->state;
}

}  // namespace touchable
