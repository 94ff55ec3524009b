#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "engine/picture/sound_track.hpp"
#include "player/audio/contact_sound.hpp"
#include "player/audio/spoken_sound.hpp"

namespace touchable {

/// The sound track of the clip in the window. A thread decodes it, from where it was read last to two seconds
/// after that.
class ClipSound {
public:
    ClipSound() = default;
    ~ClipSound();
    ClipSound(const ClipSound&) = delete;
    ClipSound& operator=(const ClipSound&) = delete;

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

}  // namespace touchable
