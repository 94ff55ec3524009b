// SPDX-License-Identifier: Apache-2.0
#pragma once

// A window's sound, and a gamepad's rumble.
//
// A session's TouchListener is its sink of ticks: it passes each finger's contact to the WindowSound (as a
// HeardTick of contact_sound.hpp). WindowSound makes sound from that, from the clip's own track and from a
// SpokenSound: for loudspeakers, fed by a separate thread, for a WAV file, for a film (FilmedSound); and it
// passes the ticks to the gamepad (GamepadRumble).
//
// Threads: ticks come on a session's, one session at a time, where nothing waits or allocates. The window's
// calls everything else, except "any thread" functions. Without sound or gamepad only these are missing:
// `state` gives the reason in a few words.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <thread>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "player/audio/contact_sound.hpp"
#include "player/audio/heard_sound.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// A short sound in memory: two channels of 16 bits at 48 kHz. Immutable.
struct SpokenSound {
    static constexpr double longest_s = 60;
    std::vector<std::array<std::int16_t, 2>> samples;

    /// Reads any file whose sound FFmpeg decodes, such as a WAV file. Fails (ErrorKind::input) without sound,
    /// or beyond `longest_s`.
    static Result<std::shared_ptr<const SpokenSound>> read(const std::filesystem::path& file);
};

/// Schedules orders to motors. Orders are short and repeated, so that motors stop by themselves without
/// further orders.
class RumbleOrders {
public:
    static constexpr int lasts_ms = 150;         ///< duration of an order
    static constexpr double renewed_s = 0.05;    ///< interval of repeated orders
    static constexpr double tick_lasts_s = 0.1;  ///< after that without a new tick, rumble is zero

    /// Call with a monotonic time, the newest tick's `rumble`, and the number of ticks so far. Returns the
    /// order to give; nullopt: the last one continues.
    std::optional<Rumble> at(double now_s, const Rumble& rumble, std::int64_t ticks);
    /// The gamepad has changed, and the new one has no order.
    void forget() { told_ = {}; }

private:
    Rumble told_;
    double told_s_ = 0, tick_s_ = 0;
    std::int64_t ticks_ = 0;
};

/// The gamepad that rumbles: the first one with motors, whichever is plugged in. One thread's, which also
/// opens it.
class Gamepad {
public:
    /// Errors (ErrorKind::device) are a few words; one is that the program was built without SDL2.
    static Result<std::unique_ptr<Gamepad>> open();
    /// Stops its motors.
    virtual ~Gamepad() = default;
    /// Detects plugging in and out; call regularly, and before each order. Returns its name; empty: none.
    virtual std::string look() = 0;
    /// Rumbles for that time. Does nothing without a gamepad.
    virtual void rumble(const Rumble& rumble, int milliseconds) = 0;
};

/// Makes a gamepad rumble with contacts, on a separate thread. Motors stop without contact, if ticks stop,
/// and when this is destroyed.
class GamepadRumble : NonCopyable {
public:
    using Open = std::function<Result<std::unique_ptr<Gamepad>>()>;

    explicit GamepadRumble(const Open& open = Gamepad::open);
    ~GamepadRumble() { stop_thread(mutex_, stopping_, stop_, thread_); }

    /// Takes the next tick on a session's thread, one session at a time. Neither waits nor allocates.
    void consume(const HeardTick& tick);
    /// In a few words, for the user.
    std::string state() const;

private:
    void say(std::string words);
    bool goes_on();
    void run(const Open& open);

    ContactRumble felt_;
    std::atomic<Rumble> newest_{};
    static_assert(std::atomic<Rumble>::is_always_lock_free, "a session's thread does not wait");
    std::atomic<std::int64_t> ticks_{0};
    mutable std::mutex mutex_;
    std::condition_variable stop_;
    bool stopping_ = false;
    std::string state_ = "rumble: looking for a gamepad";
    std::thread thread_;
};

/// Makes sound from the contacts of the window's fingers, and adds the clip's own sound: for loudspeakers,
/// for a file, or for both.
class WindowSound {
public:
    /// `file`: the WAV file to write, with or without loudspeakers; nullopt: none. The loudspeakers are
    /// opened on a separate thread.
    static Result<std::unique_ptr<WindowSound>> create(bool loudspeakers,
                                                       const std::optional<std::filesystem::path>& file,
                                                       Existing existing, std::string name = "the sound");
    ~WindowSound();

    /// Consumes the next known tick, on a session's thread, one session at a time. `passed`: ticks since the
    /// previous one; more than 1 if those between are unknown.
    void consume(HeardTick tick, std::int64_t passed);
    /// Another session's ticks follow. Any thread.
    void begin_session() {
        if (is_filmed_.load(std::memory_order_acquire)) film_->align();
    }

    // For the window's thread.
    /// Makes a gamepad, if there is one, rumble with contacts, independent of the volume. Once, before the
    /// first session.
    void begin_rumble() { rumble_.emplace(); }
    /// In a few words, for the user; empty: rumble was not begun.
    std::string rumble_state() const { return rumble_ ? rumble_->state() : std::string(); }
    /// Uses this file's sound, if it has any, as the clip's own.
    void open_clip(const std::filesystem::path& file) { clip_->open(file); }
    /// ClipSound::wait_for_decoding, of all clips.
    void wait_for_decoding() { clip_->wait_for_decoding(); }
    /// Passes all sound from now on to a film, at `now_ms` of its time (any thread). Once; both must outlive
    /// the sessions.
    void film(FilmedSound::Keep keep, std::function<std::int64_t()> now_ms);
    /// Volume of all sound, 0 to 100; half of it sounds half as loud (a factor of 1/8).
    void set_volume(int percent) { volume_.store(std::clamp(percent, 0, 100), std::memory_order_relaxed); }
    int volume() const { return volume_.load(std::memory_order_relaxed); }
    /// The sounds for `say`. Call before the first session.
    void set_spoken(std::vector<std::shared_ptr<const SpokenSound>> sounds);
    /// Plays one of them from its start, replacing the current one.
    void say(std::size_t sound);
    void set_muted(bool muted) { muted_.store(muted, std::memory_order_relaxed); }
    /// Mutes contacts, but not the clip's own sound.
    void silence_fingers(bool silent) { fingers_silent_.store(silent, std::memory_order_relaxed); }
    bool is_muted() const { return muted_.load(std::memory_order_relaxed); }
    /// Why a clip with a sound track is silent, or in part; otherwise empty.
    std::string clip_fault() const { return clip_->fault(); }
    /// Why the file gets no more; nullopt: it does, or there is none.
    std::optional<Error> file_fault() const;
    /// In a few words, for the user.
    std::string state() const;
    /// Completes the file. After the last session's end.
    Result<void> finish();

private:
    class WavFile;
    class Loudspeakers;
    WindowSound();

    std::atomic<bool> muted_{false}, fingers_silent_{false};
    std::atomic<int> volume_{100};
    struct alignas(8) Said {
        std::uint32_t number = 0, sound = 0;  // how many sounds were spoken; the index of the last one
    };
    std::vector<std::shared_ptr<const SpokenSound>> spoken_;
    std::atomic<Said> said_{};
    static_assert(std::atomic<Said>::is_always_lock_free, "a session's thread does not wait");
    std::shared_ptr<ClipSound> clip_ = std::make_shared<ClipSound>();
    std::shared_ptr<HeardTicks> ticks_ = std::make_shared<HeardTicks>(clip_);
    std::optional<FilmedSound> film_;
    std::function<std::int64_t()> film_now_ms_;
    std::atomic<bool> is_filmed_{false};
    std::unique_ptr<WavFile> file_;
    std::optional<GamepadRumble> rumble_;
    HeardSound kept_;  // for the file: renders every tick, independent of the loudspeakers
    ContactSound::Samples samples_{};
    std::unique_ptr<Loudspeakers> output_;
};

/// Derives sound from the contacts of a session's fingers.
class TouchListener final : public TouchSink {
public:
    /// `sound` must outlive it. `width`: of the clip, pixels.
    TouchListener(WindowSound& sound, int width) : sound_(sound), contacts_(width) {}
    /// Starts the sound: one clip at a time, each after the previous one's session has ended. `clock` is the
    /// clip's, which ends at `end_ns`.
    void begin(PlaybackClock clock, std::int64_t end_ns) {
        clock_ = std::move(clock);
        end_ns_ = end_ns;
        sound_.begin_session();
        begun_.store(true, std::memory_order_release);
    }
    Result<void> consume(const TouchTick& tick) override;

private:
    HeardClip hear_clip(std::int64_t tick);

    WindowSound& sound_;
    HeardContacts contacts_;
    std::atomic<bool> begun_{false};
    std::optional<PlaybackClock> clock_;  // since `begin`
    std::int64_t end_ns_ = 0;
    std::int64_t last_tick_ = -1;
};

}  // namespace touchable
