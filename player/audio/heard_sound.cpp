#include "player/audio/heard_sound.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engine/base/start_thread.hpp"

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

namespace {

constexpr double samples_per_ns = SoundTrack::rate * 1e-9;
constexpr double farthest = 0.06 * SoundTrack::rate;  // from where it should be, samples: beyond, it jumps
constexpr double most_correction = 0.003, correction_s = 1;

/// Between the second and the third of four, by Catmull and Rom's cubic.
float between(const float* four, float share) {
    const float a = four[3] - 3 * four[2] + 3 * four[1] - four[0];
    const float b = 2 * four[0] - 5 * four[1] + 4 * four[2] - four[3];
    const float c = four[2] - four[0];
    return four[1] + 0.5F * share * (c + share * (b + share * a));
}

StereoSample at(std::span<const StereoSample> samples, double place) {
    const auto first = static_cast<std::size_t>(place);
    const auto share = static_cast<float>(place - static_cast<double>(first));
    std::array<float, 4> left{}, right{};
    for (std::size_t k = 0; k < 4; ++k) {
        left[k] = samples[first + k].left;
        right[k] = samples[first + k].right;
    }
    return {between(left.data(), share), between(right.data(), share)};
}

}  // namespace

/// Samples of the clip for one that is heard; brings the place to where the tick is.
double ClipVoice::step_to(const HeardTick& tick) {
    const HeardClip& clip = tick.clip;
    const double target = static_cast<double>(clip.at_ns) * samples_per_ns;
    const double speed = std::clamp(static_cast<double>(clip.speed), 0.0, fastest);
    const bool jumps = !follows_ || epoch_ != clip.epoch || std::abs(target - position_) > farthest;
    if (jumps && volume_ == 0) {
        position_ = target;
        epoch_ = clip.epoch;
        follows_ = true;
    } else if (jumps) {
        follows_ = false;  // once it has faded
    }
    const double error_s = (target - position_) / SoundTrack::rate;
    return speed * (1 + std::clamp(error_s / correction_s, -most_correction, most_correction));
}

void ClipVoice::add(const HeardTick& tick, ClipSound& sound, ContactSound::Samples& to) {
    const bool is_heard = tick.clip.plays && !tick.muted;
    if (!is_heard && volume_ == 0) {
        follows_ = false;
        return;
    }
    const double step = step_to(tick);
    constexpr auto count = static_cast<std::size_t>(ContactSound::samples_per_tick);
    // Those of the next tick too: before samples that are not there it has to have faded.
    std::array<StereoSample, static_cast<std::size_t>(2 * count * (fastest + 1)) + 4> samples;
    const double first = std::floor(position_) - 1;
    const std::size_t needed = static_cast<std::size_t>(2 * step * count) + 5;
    const std::span<StereoSample> there = std::span(samples).first(std::min(needed, samples.size()));
    const bool is_there = sound.read(static_cast<std::int64_t>(first), there);
    const double from = volume_, until = is_heard && follows_ && is_there ? 1 : 0;
    volume_ = until;
    for (std::size_t k = 0; k < count; ++k) {
        const StereoSample sample = at(there, position_ - first - 1 + step * static_cast<double>(k));
        const auto volume = static_cast<float>(from + (until - from) * static_cast<double>(k + 1) / count);
        to[k].left += volume * sample.left;
        to[k].right += volume * sample.right;
    }
    position_ += step * count;
}

void HeardSound::render(const HeardTick& tick, ClipSound& clip, ContactSound::Samples& samples) {
    contacts_.render(tick, samples);
    clip_.add(tick, clip, samples);
    // Another loudness is glided to: a step would click.
    const float from = std::exchange(loudness_, tick.loudness),
                step = (loudness_ - from) / static_cast<float>(samples.size());
    float loudness = from;
    spoken_.add(tick.spoken, tick.spoken_number, tick.muted, samples);
    for (StereoSample& sample : samples) {
        loudness += step;
        // A damaged track may give anything.
        sample.left = std::isfinite(sample.left) ? loudness * std::clamp(sample.left, -1.0F, 1.0F) : 0;
        sample.right = std::isfinite(sample.right) ? loudness * std::clamp(sample.right, -1.0F, 1.0F) : 0;
    }
}

}  // namespace touchable
