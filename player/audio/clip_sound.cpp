#include "player/audio/clip_sound.hpp"

#include <algorithm>
#include <utility>

#include "engine/start_thread.hpp"

namespace touchable {

ClipSound::~ClipSound() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    news_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void ClipSound::open(const std::filesystem::path& file) {
    {
        const std::lock_guard lock(mutex_);
        file_ = file;
        is_new_ = true;
        has_track_ = false;
        fault_.clear();
        blocks_.clear();
        wanted_ = 0;
    }
    if (thread_.joinable()) return news_.notify_all();
    const auto begun = start_thread(thread_, "clip-sound", "of the clip's sound", [this] { run(); });
    if (begun.ok()) return;
    const std::lock_guard lock(mutex_);
    fault_ = begun.error().message;
}

bool ClipSound::read(std::int64_t first, std::span<StereoSample> to) {
    std::fill(to.begin(), to.end(), StereoSample{});
    const std::lock_guard lock(mutex_);
    if (!has_track_) return false;
    bool is_there = true;
    for (std::int64_t k = std::max<std::int64_t>(-first, 0); k < std::ssize(to);) {
        const std::int64_t number = (first + k) / block, offset = (first + k) % block;
        const std::int64_t count = std::min(block - offset, std::ssize(to) - k);
        const Block& from = place_of(number);
        if (from.number == number)
            std::copy_n(from.samples.begin() + offset, count, to.begin() + k);
        else
            is_there = false;
        k += count;
    }
    const std::int64_t wanted = std::max<std::int64_t>(first, 0) / block;
    if (std::exchange(wanted_, wanted) != wanted) news_.notify_all();
    return is_there;
}

std::string ClipSound::fault() const {
    const std::lock_guard lock(mutex_);
    return fault_;
}

/// The next block to decode. Under the lock.
std::optional<std::int64_t> ClipSound::missing() {
    if (!has_track_) return std::nullopt;
    for (std::int64_t number = wanted_; number <= wanted_ + ahead; ++number)
        if (place_of(number).number != number) return number;
    return std::nullopt;
}

void ClipSound::take_file(std::unique_lock<std::mutex>& lock, std::unique_ptr<SoundTrack>& track) {
    is_new_ = false;
    const std::filesystem::path file = file_;
    lock.unlock();
    auto opened = SoundTrack::open(file);
    lock.lock();
    if (is_new_) return;  // another one meanwhile
    track = opened.ok() ? std::move(*opened) : nullptr;
    if (!opened.ok()) fault_ = opened.error().message;
    has_track_ = track != nullptr;
    if (has_track_) blocks_.resize(static_cast<std::size_t>(ahead) + 8);
}

void ClipSound::run() {
    std::unique_ptr<SoundTrack> track;
    std::int64_t next = 0;  // that `track` goes on with
    std::array<StereoSample, block> samples{};
    std::unique_lock lock(mutex_);
    while (true) {
        std::optional<std::int64_t> number;
        news_.wait(lock, [&] { return stopping_ || is_new_ || (number = missing()).has_value(); });
        if (stopping_) return;
        if (is_new_) {
            take_file(lock, track);
            next = 0;
            continue;
        }
        lock.unlock();
        if (*number != next) track->seek(*number * block);
        track->read(samples);
        next = *number + 1;
        lock.lock();
        // What nobody wants any more by now would take the place of what is heard.
        if (is_new_ || *number < wanted_ || *number > wanted_ + ahead) continue;
        Block& to = place_of(*number);
        to.number = *number;
        to.samples = samples;
        if (track->is_damaged()) fault_ = file_.string() + ": its sound is damaged, and silent where it is";
    }
}

}  // namespace touchable
