#pragma once

// The parts of what is heard, and their mixture.
//
// ClipSound decodes a clip's own track ahead on a thread of its own, and ClipVoice plays it at the clip's
// moments and speed; SpokenVoice says a SpokenSound (window_sound.hpp); ContactSound is what fingers feel.
// HeardSound is all three, a millisecond at a time. HeardTicks brings ticks from a session's thread to the
// thread of a SoundDevice, FilmedSound keeps a film's sound in step with its pictures.
//
// Each object is one thread's, but for ClipSound and HeardTicks, whose functions name theirs.

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
#include "player/audio/contact_sound.hpp"

namespace touchable {

/// Says one sound after the other, each from its begin; what is heard besides is softer meanwhile.
class SpokenVoice {
public:
    /// Adds the next millisecond to `to`. `sound` outlives it; null: none. `number`: another one begins it.
    void add(const SpokenSound* sound, std::uint32_t number, bool is_muted, ContactSound::Samples& to);

private:
    static constexpr float beside = 0.35F;  // of what is heard besides
    const SpokenSound* sound_ = nullptr;
    std::uint32_t number_ = 0;
    std::size_t next_ = 0;  // sample
    float volume_ = 0;      // of what is said
    float others_ = 1;      // of what is not
};

/// The sound track of the clip in the window. A thread decodes it, from where it was read last to two seconds
/// after that.
class ClipSound : NonCopyable {
public:
    ClipSound() = default;
    ~ClipSound();

    /// From now on that of this file, if it has one, as it is now; the one before is silent at once. The
    /// window's thread.
    void open(const std::filesystem::path& file);
    /// Copies the samples from `first` on; silence where there are none, or none yet, which is false. Any
    /// thread; waits for no decoding.
    bool read(std::int64_t first, std::span<StereoSample> to);
    /// Why a clip with a sound track is silent, or in part; otherwise nothing. Any thread.
    std::string fault() const;

    static constexpr std::int64_t block = 4096;  ///< samples that are decoded at once
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
    std::optional<std::int64_t> missing();
    void take_file(std::unique_lock<std::mutex>& lock, std::unique_ptr<SoundTrack>& track);

    mutable std::mutex mutex_;
    std::condition_variable news_;
    // Guarded by it.
    std::filesystem::path file_;
    bool is_new_ = false, stopping_ = false, has_track_ = false;
    std::int64_t wanted_ = 0;  // block
    std::vector<Block> blocks_;
    std::string fault_;
    std::thread thread_;
};

/// The clip's sound at the clip's moments and speed: at half the speed an octave lower, as from a tape. Where
/// ticks and samples come by clocks that differ, it is played up to 0.3 % faster or slower; a jump in the
/// clip's time is a fade of a millisecond on each side.
class ClipVoice {
public:
    /// Adds the next millisecond.
    void add(const HeardTick& tick, ClipSound& sound, ContactSound::Samples& to);

    static constexpr double fastest = 8;

private:
    double step_to(const HeardTick& tick);

    double position_ = 0, volume_ = 0;  // samples of the clip; 0 to 1
    bool follows_ = false;
    std::uint64_t epoch_ = 0;
};

/// All that is heard: contacts, the clip's own sound, and what is said.
class HeardSound {
public:
    /// The next millisecond; samples are within -1 and 1.
    void render(const HeardTick& tick, ClipSound& clip, ContactSound::Samples& samples);

private:
    ContactSound contacts_;
    ClipVoice clip_;
    float loudness_ = 1;  // of the tick before
    SpokenVoice spoken_;
};

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

/// Keeps the sound of a film in step with its pictures, while sessions end and others begin. Within a session
/// ticks count the time, and come a few at a time; between two sessions the film's own clock does.
class FilmedSound {
public:
    /// Takes samples; `first`: the number of the first of them in the film.
    using Keep = std::function<void(std::int64_t first, std::span<const StereoSample>)>;
    explicit FilmedSound(Keep keep) : keep_(std::move(keep)) {}

    /// Another session begins, after a time without ticks. Any thread.
    void align() { aligns_.store(true, std::memory_order_relaxed); }
    /// As WindowSound::take has it; `now_ms`: of the film.
    void take(const HeardTick& tick, std::int64_t passed, ClipSound& clip, std::int64_t now_ms);

private:
    void render(const HeardTick& tick, ClipSound& clip);
    void skip_to(std::int64_t now_ms, const HeardTick& tick, ClipSound& clip);

    Keep keep_;
    std::atomic<bool> aligns_{true};
    HeardSound sound_;
    std::int64_t next_ms_ = 0;
    std::optional<HeardTick> early_;  // what happened in ticks that were left out
    ContactSound::Samples samples_{};
};

/// Where samples at 48 kHz are heard: two channels of the system's own output. One thread's.
class SoundDevice {
public:
    static constexpr int buffer = 1920;  ///< samples that wait in it: 40 ms

    /// May take long where the system's sound does. Errors (ErrorKind::device) are a few words; so it is
    /// where the program was built without ALSA.
    static Result<std::unique_ptr<SoundDevice>> open();
    virtual ~SoundDevice() = default;
    /// Whether there is room for so many samples, after `longest` at most.
    virtual Result<bool> wait_for(int samples, std::chrono::milliseconds longest) = 0;
    virtual Result<void> write(std::span<const StereoSample> samples) = 0;
};

}  // namespace touchable
