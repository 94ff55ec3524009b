// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sources of sound, and their mixer.
//
// ClipSound decodes a clip's own track ahead on a separate thread, and ClipVoice plays it at the clip's time
// and speed; SpokenVoice plays a SpokenSound (window_sound.hpp); ContactSound renders contacts. HeardSound
// mixes all three, a millisecond at a time. HeardTicks passes ticks from a session's thread to the thread of
// a SoundDevice; FilmedSound keeps a film's sound in sync with its pictures.
//
// Each object belongs to one thread, except ClipSound and HeardTicks, whose functions name theirs.

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <thread>

#include "engine/base/result.hpp"
#include "engine/picture/sound.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// Plays one sound after another from its start; other sound is softer meanwhile.
class SpokenVoice {
public:
    /// Adds the next millisecond to `to`. `sound` must outlive it; null: none. A new `number` starts it.
    void add(const SpokenSound* sound, std::uint32_t number, bool is_muted, ContactSound::Samples& to);

private:
    static constexpr float beside = 0.35F;  // factor on other sound
    const SpokenSound* sound_ = nullptr;
    std::uint32_t number_ = 0;
    std::size_t next_ = 0;  // sample index
    float volume_ = 0;      // of the spoken sound
    float others_ = 1;      // of other sound
};

/// The sound track of the window's clip. A thread decodes from the last position read to two seconds ahead.
class ClipSound : NonCopyable {
public:
    ClipSound() = default;
    ~ClipSound() { stop_thread(mutex_, stopping_, news_, thread_); }

    /// Switches to this file's track, if it has one; the previous one is silent at once. The window's thread.
    void open(const std::filesystem::path& file);
    /// From now on `read` waits for decoding, so that the same is heard on each run. Before everything else.
    void wait_for_decoding() { waits_ = true; }
    /// Copies the samples from `first` on, with silence for missing ones; returns false without a track, or
    /// if some are not decoded yet. Any thread; does not wait for decoding by default.
    bool read(std::int64_t first, std::span<StereoSample> to);
    /// Why a clip with a sound track is silent, or in part; otherwise empty. Any thread.
    std::string fault() const;

    static constexpr std::int64_t block = 4096;  ///< samples decoded at once
    static constexpr std::int64_t ahead = 24;    ///< blocks

private:
    struct Block {
        std::int64_t number = -1;
        std::array<StereoSample, block> samples{};
    };
    void run();
    Block& place_of(std::int64_t number) {
        return blocks_[static_cast<std::size_t>(number) % blocks_.size()];
    }
    bool is_new() const { return asked_ != opened_; }
    std::optional<std::int64_t> missing();
    /// The last block to decode ahead. Waiting: no more than a read needs, as it would depend on the time.
    std::int64_t last_wanted() const { return wanted_ + (waits_ ? 1 : ahead); }
    void take_file(std::unique_lock<std::mutex>& lock, std::unique_ptr<SoundTrack>& track);

    bool waits_ = false;
    mutable std::mutex mutex_;
    std::condition_variable news_;
    // Guarded by `mutex_`.
    std::filesystem::path file_;
    std::uint64_t asked_ = 0, opened_ = 0;  // files, counted
    bool stopping_ = false, has_track_ = false;
    std::int64_t wanted_ = 0;  // block
    std::vector<Block> blocks_;
    std::string fault_;
    std::thread thread_;
};

/// Plays the clip's sound at the clip's time and speed: at half the speed an octave lower, like a tape. To
/// compensate different clocks of ticks and samples, it plays up to 0.3 % faster or slower; a jump in the
/// clip's time is a fade of a millisecond on each side.
class ClipVoice {
public:
    /// Adds the next millisecond to `to`.
    void add(const HeardTick& tick, ClipSound& sound, ContactSound::Samples& to);

    static constexpr double fastest = 8;

private:
    double step_to(const HeardTick& tick);

    double position_ = 0, volume_ = 0;  // samples of the clip; 0 to 1
    bool follows_ = false;
    std::uint64_t epoch_ = 0;
};

/// Mixes all sound: contacts, the clip's own sound, and spoken sounds.
class HeardSound {
public:
    /// Renders the next millisecond; samples are within -1 and 1.
    void render(const HeardTick& tick, ClipSound& clip, ContactSound::Samples& samples);

private:
    ContactSound contacts_;
    ClipVoice clip_;
    float loudness_ = 1;  // of the previous tick
    SpokenVoice spoken_;
};

/// Queue of ticks from a session's thread to a sound device's, which renders them. Neither waits for the
/// other, and neither allocates. Their clocks differ: if the device lags, ticks are merged; if it is ahead,
/// the last one continues for a short time, and then fades.
class HeardTicks {
public:
    explicit HeardTicks(std::shared_ptr<ClipSound> clip) : clip_(std::move(clip)) {}
    /// Keeps spoken sounds alive. Call before everything else.
    void keep(std::vector<std::shared_ptr<const SpokenSound>> sounds) { spoken_ = std::move(sounds); }
    /// The session's thread. Ticks that find no room are dropped.
    void push(const HeardTick& tick) {
        ticks_.push([&tick](HeardTick& slot) { slot = tick; });
    }
    /// The device's thread: renders the next samples. Ticks before the first call are dropped.
    void fill(std::span<StereoSample> samples);

    static constexpr std::size_t most_waiting = 256;
    /// Ticks left queued beyond a call's need, as sessions deliver a few at a time.
    static constexpr std::size_t slack = 12;
    static constexpr int longest_bridge = 20;  ///< ticks for which the last one continues

private:
    HeardTick next(std::size_t wanted);

    SpscRing<HeardTick> ticks_{std::vector<HeardTick>(most_waiting)};
    // Data of the device's thread.
    HeardSound sound_;
    std::shared_ptr<ClipSound> clip_;
    std::vector<std::shared_ptr<const SpokenSound>> spoken_;
    ContactSound::Samples samples_{};
    std::size_t played_ = ContactSound::samples_per_tick;  // of `samples_`
    HeardTick last_;
    int bridged_ = longest_bridge;
    bool begun_ = false;
};

/// Keeps a film's sound in sync with its pictures across sessions. Within a session ticks count the time, and
/// come a few at a time; between two sessions the film's clock does.
class FilmedSound {
public:
    /// Receives samples; `first`: the film's number of the first one.
    using Keep = std::function<void(std::int64_t first, std::span<const StereoSample>)>;
    explicit FilmedSound(Keep keep) : keep_(std::move(keep)) {}

    /// A new session begins, after a time without ticks. Any thread.
    void align() { aligns_.store(true, std::memory_order_relaxed); }
    /// Arguments as in WindowSound::consume; `now_ms`: time of the film.
    void consume(const HeardTick& tick, std::int64_t passed, ClipSound& clip, std::int64_t now_ms);

private:
    void render(const HeardTick& tick, ClipSound& clip);
    void skip_to(std::int64_t now_ms, const HeardTick& tick, ClipSound& clip);

    Keep keep_;
    std::atomic<bool> aligns_{true};
    HeardSound sound_;
    std::int64_t next_ms_ = 0;
    std::optional<HeardTick> early_;  // events of dropped ticks
    ContactSound::Samples samples_{};
};

/// The system's sound output: two channels at 48 kHz. One thread's.
class SoundDevice {
public:
    static constexpr int buffer = 1920;  ///< samples queued in it: 40 ms

    /// As slow as the system's sound may be. Errors (ErrorKind::device) are a few words; one of them is that
    /// the program was built without ALSA.
    static Result<std::unique_ptr<SoundDevice>> open();
    virtual ~SoundDevice() = default;
    /// Waits for room for `samples`, for `longest` at most; returns whether there is room.
    virtual Result<bool> wait_for(int samples, std::chrono::milliseconds longest) = 0;
    virtual Result<void> write(std::span<const StereoSample> samples) = 0;
};

}  // namespace touchable
