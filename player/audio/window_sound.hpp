#pragma once

// What is heard of a window, and what a gamepad's motors do.
//
// A session's TouchListener is its sink of ticks: it tells the WindowSound what each finger feels (a
// HeardTick, as of contact_sound.hpp). WindowSound makes a sound of that, of the clip's own track and of a
// SpokenSound that is said: for loudspeakers, which a thread of its own feeds, for a WAV file, for a film
// (FilmedSound); and it hands the ticks to the gamepad (GamepadRumble).
//
// Ticks come by a session's thread, one session at a time; it neither waits nor allocates there. The window's
// thread calls everything else, unless it says "any thread". A machine without sound or gamepad loses only
// these: `state` says why in a few words.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <glm/vec3.hpp>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "player/audio/contact_sound.hpp"
#include "player/audio/heard_sound.hpp"
#include "player/audio/rumble.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// A short sound, whole in memory: two channels of 16 bits at 48 kHz. Never changed.
struct SpokenSound {
    static constexpr double longest_s = 60;
    std::vector<std::array<std::int16_t, 2>> samples;

    /// Of any file whose sound FFmpeg decodes, such as a WAV file. Refused (ErrorKind::input): one without
    /// sound, or of more than `longest_s`.
    static Result<std::shared_ptr<const SpokenSound>> read(const std::filesystem::path& file);
};

/// Makes a sound of what the window's fingers feel, and adds the clip's own sound: for loudspeakers, for a
/// file, or for both.
class WindowSound {
public:
    /// `file`: where the sound is written, with or without loudspeakers; nothing: nowhere. The loudspeakers
    /// are opened on a thread of their own.
    static Result<std::unique_ptr<WindowSound>> create(bool loudspeakers,
                                                       const std::optional<std::filesystem::path>& file,
                                                       Existing existing, std::string name = "the sound");
    ~WindowSound();

    /// The next tick that is known, from a session's thread, one session at a time. `passed`: how many ticks
    /// it is after the one before; more than 1 where those between are not known.
    void take(HeardTick tick, std::int64_t passed);
    /// Another session's ticks come next. Any thread.
    void begin_session() {
        if (is_filmed_.load(std::memory_order_acquire)) film_->align();
    }

    // The window's.
    /// From now on a gamepad, if there is one, rumbles by what is felt, however loud it is. Once, before the
    /// first session.
    void begin_rumble() { rumble_.emplace(); }
    /// In a few words, for a person; empty: it was not begun.
    std::string rumble_state() const { return rumble_ ? rumble_->state() : std::string(); }
    /// The clip's own sound, if it has any, is that of this file from now on.
    void open_clip(const std::filesystem::path& file) { clip_->open(file); }
    /// A film that began at `begun` gets what is heard from now on. Once; sessions end before `keep` does.
    void film(FilmedSound::Keep keep, std::chrono::steady_clock::time_point begun);
    /// Of all that is heard and kept, 0 to 100; half of it sounds half as loud (a factor of 1/8).
    void set_volume(int percent) { volume_.store(std::clamp(percent, 0, 100), std::memory_order_relaxed); }
    int volume() const { return volume_.load(std::memory_order_relaxed); }
    /// What `say` can say. Before the first session.
    void set_spoken(std::vector<std::shared_ptr<const SpokenSound>> sounds);
    /// One of these, from its begin, in place of another that is still being said.
    void say(std::size_t sound);
    void set_muted(bool muted) { muted_.store(muted, std::memory_order_relaxed); }
    /// No finger is heard; the clip's own sound is.
    void silence_fingers(bool silent) { fingers_silent_.store(silent, std::memory_order_relaxed); }
    bool is_muted() const { return muted_.load(std::memory_order_relaxed); }
    /// Why a clip with a sound track is silent, or in part; otherwise nothing.
    std::string clip_fault() const { return clip_->fault(); }
    /// Why the file gets no more; nothing where it does, or there is none.
    std::optional<Error> file_fault() const;
    /// In a few words, for a person.
    std::string state() const;
    /// Completes the file. After the last session's end.
    Result<void> finish();

private:
    class WavFile;
    class Loudspeakers;
    WindowSound();

    std::atomic<bool> muted_{false}, fingers_silent_{false};
    std::atomic<int> volume_{100};
    static constexpr std::uint32_t most_spoken = 1024;
    std::vector<std::shared_ptr<const SpokenSound>> spoken_;
    std::atomic<std::uint32_t> said_{0};  // how often something was said, times most_spoken, and what
    std::shared_ptr<ClipSound> clip_ = std::make_shared<ClipSound>();
    std::shared_ptr<HeardTicks> ticks_ = std::make_shared<HeardTicks>(clip_);
    std::optional<FilmedSound> film_;
    std::chrono::steady_clock::time_point film_begun_;
    std::atomic<bool> is_filmed_{false};
    std::unique_ptr<WavFile> file_;
    std::optional<GamepadRumble> rumble_;
    HeardSound kept_;  // what the file has: of every tick, whatever the loudspeakers do
    ContactSound::Samples samples_{};
    std::unique_ptr<Loudspeakers> output_;
};

/// Hears what the fingers of one session do.
class TouchListener final : public TouchSink {
public:
    /// `sound` outlives it. `width`: of the clip, pixels.
    TouchListener(WindowSound& sound, int width) : sound_(sound), width_(width) {}
    /// Until then nothing is heard: one clip at a time, each after the session of the one before has ended.
    /// `clock` is the clip's, which ends at `end_ns`.
    void begin(PlaybackClock clock, std::int64_t end_ns) {
        clock_ = std::move(clock);
        end_ns_ = end_ns;
        sound_.begin_session();
        begun_.store(true, std::memory_order_release);
    }
    Result<void> take(const TouchTick& tick) override;

private:
    /// Of a finger, the tick before.
    struct Before {
        bool touching = false, stuck = false;
        glm::dvec3 goal{0.0}, force{0.0};
    };
    HeardFinger hear(const TouchTick& tick, std::size_t finger);
    HeardClip hear_clip(std::int64_t tick);

    WindowSound& sound_;
    int width_;
    std::atomic<bool> begun_{false};
    std::optional<PlaybackClock> clock_;  // once it has begun
    std::int64_t end_ns_ = 0;
    std::array<Before, HeardTick::most_fingers> before_{};
    std::int64_t last_tick_ = -1;
};

}  // namespace touchable
