// SPDX-License-Identifier: Apache-2.0
#include "player/audio/heard_sound.hpp"

#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "player/audio/window_sound.hpp"

namespace touchable {
namespace {

constexpr std::size_t samples_read = 4096;

constexpr double samples_per_ns = SoundTrack::rate * 1e-9;
constexpr double farthest = 0.06 * SoundTrack::rate;  // samples; a larger error is corrected by a jump
constexpr double most_correction = 0.003, correction_s = 1;

/// Interpolates between the second and third of four samples with a Catmull-Rom cubic.
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

constexpr std::int64_t fade_ms = 60;            // of the last sound when a session ended
constexpr std::int64_t longest_skip_ms = 1000;  // of unknown ticks; longer means that the computer slept

}  // namespace

/// A track's length is not known: it is silent beyond its end.
Result<std::shared_ptr<const SpokenSound>> SpokenSound::read(const std::filesystem::path& file) {
    const auto refuse = [&file](const std::string& why) {
        return input_error(file.string() + ": " + why +
                           "; expected a sound of up to 60 s, such as a WAV file");
    };
    TRY(GivenFile::open(file, file.string(), "a sound of up to 60 s, such as a WAV file"));
    TRY_ASSIGN(const auto track, SoundTrack::open(file));
    if (!track) return refuse("has no sound");
    auto sound = std::make_shared<SpokenSound>();
    const auto most = static_cast<std::size_t>(longest_s * SoundTrack::rate);
    std::size_t end = 0;  // one past the last audible sample
    std::array<StereoSample, samples_read> samples{};
    while (sound->samples.size() <= most) {
        track->read(samples);
        for (const StereoSample& sample : samples) {
            sound->samples.push_back(in_16_bits(sample));
            if (sound->samples.back() != std::array<std::int16_t, 2>{}) end = sound->samples.size();
        }
    }
    if (track->is_damaged()) return refuse("its sound is damaged");
    if (end > most) return refuse("is longer than 60 s");
    if (end == 0) return refuse("is silent");
    sound->samples.resize(end);
    sound->samples.shrink_to_fit();
    return std::shared_ptr<const SpokenSound>(std::move(sound));
}

void SpokenVoice::add(const SpokenSound* sound, std::uint32_t number, bool is_muted,
                      ContactSound::Samples& to) {
    constexpr float rise = 1.0F / 96, soften = 1.0F / 2400;  // per sample: 2 ms and 50 ms
    const bool is_another = sound && number != number_;
    if (!is_another && !sound_ && others_ == 1) return;
    for (StereoSample& sample : to) {
        // The current sound fades before another one begins.
        if (is_another && volume_ == 0 && number_ != number) {
            sound_ = sound;
            number_ = number;
            next_ = 0;
        }
        const bool goes_on = sound_ && number_ == (sound ? number : number_) && !is_muted;
        volume_ = std::clamp(volume_ + (goes_on ? rise : -rise), 0.0F, 1.0F);
        others_ = std::clamp(others_ + (goes_on ? -soften : soften), beside, 1.0F);
        sample.left *= others_;
        sample.right *= others_;
        if (!sound_) continue;
        const auto& [left, right] = sound_->samples[next_];
        sample.left += volume_ * static_cast<float>(left) / 32767;
        sample.right += volume_ * static_cast<float>(right) / 32767;
        if (++next_ == sound_->samples.size()) {
            sound_ = nullptr;
            volume_ = 0;
        }
    }
}

void ClipSound::open(const std::filesystem::path& file) {
    {
        const std::lock_guard lock(mutex_);
        file_ = file;
        ++asked_;
        has_track_ = false;
        fault_.clear();
        blocks_.clear();
        wanted_ = 0;
    }
    if (thread_.joinable()) return news_.notify_all();
    const auto begun = start_thread(thread_, "clip-sound", "of the clip's sound", [this] { run(); });
    if (begun) return;
    const std::lock_guard lock(mutex_);
    fault_ = begun.error().message;
}

bool ClipSound::read(std::int64_t first, std::span<StereoSample> to) {
    std::fill(to.begin(), to.end(), StereoSample{});
    const std::int64_t wanted = std::max<std::int64_t>(first, 0) / block;
    std::unique_lock lock(mutex_);
    if (waits_ && thread_.joinable()) {
        constexpr std::chrono::milliseconds pause(20);
        wanted_ = wanted;
        news_.notify_all();
        while ((is_new() || missing()) && !stop_requested()) news_.wait_for(lock, pause);
    }
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
    if (std::exchange(wanted_, wanted) != wanted) news_.notify_all();
    return is_there;
}

std::string ClipSound::fault() const {
    const std::lock_guard lock(mutex_);
    return fault_;
}

/// The next block to decode; the caller holds the lock.
std::optional<std::int64_t> ClipSound::missing() {
    if (!has_track_) return std::nullopt;
    for (std::int64_t number = wanted_; number <= last_wanted(); ++number)
        if (place_of(number).number != number) return number;
    return std::nullopt;
}

void ClipSound::take_file(std::unique_lock<std::mutex>& lock, std::unique_ptr<SoundTrack>& track) {
    const std::filesystem::path file = file_;
    const std::uint64_t asked = asked_;
    lock.unlock();
    auto opened = SoundTrack::open(file);
    lock.lock();
    if (asked_ != asked) return;  // another file meanwhile
    opened_ = asked;
    track = opened ? std::move(*opened) : nullptr;
    if (!opened) fault_ = opened.error().message;
    has_track_ = track != nullptr;
    if (has_track_) blocks_.resize(static_cast<std::size_t>(ahead) + 8);
}

void ClipSound::run() {
    std::unique_ptr<SoundTrack> track;
    std::int64_t next = 0;  // the block that `track` reads next
    std::array<StereoSample, block> samples{};
    std::unique_lock lock(mutex_);
    while (true) {
        std::optional<std::int64_t> number;
        news_.wait(lock, [&] { return stopping_ || is_new() || (number = missing()).has_value(); });
        if (stopping_) return;
        if (is_new()) {
            take_file(lock, track);
            next = 0;
            continue;
        }
        lock.unlock();
        if (*number != next) track->seek(*number * block);
        track->read(samples);
        next = *number + 1;
        lock.lock();
        // A block that is no longer wanted would replace an audible one.
        if (is_new() || *number < wanted_ || *number > last_wanted()) continue;
        Block& to = place_of(*number);
        to.number = *number;
        to.samples = samples;
        news_.notify_all();
        if (track->is_damaged()) fault_ = file_.string() + ": its sound is damaged, and silent where it is";
    }
}

/// Samples of the clip per output sample; moves the position toward the tick's.
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
        follows_ = false;  // jumps after fading
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
    // Includes the next tick's samples: the sound must fade before missing ones.
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
    // Ramps a changed loudness: a step would click.
    const float from = std::exchange(loudness_, tick.loudness),
                step = (loudness_ - from) / static_cast<float>(samples.size());
    float loudness = from;
    spoken_.add(tick.spoken, tick.spoken_number, tick.muted, samples);
    for (StereoSample& sample : samples) {
        loudness += step;
        // A damaged track may have any values.
        sample.left = std::isfinite(sample.left) ? loudness * std::clamp(sample.left, -1.0F, 1.0F) : 0;
        sample.right = std::isfinite(sample.right) ? loudness * std::clamp(sample.right, -1.0F, 1.0F) : 0;
    }
}

/// The tick to render now; `wanted` more follow in this call.
HeardTick HeardTicks::next(std::size_t wanted) {
    if (!ticks_.pop([this](const HeardTick& tick) { last_ = tick; }))
        return ++bridged_ <= longest_bridge ? going_on(last_) : silence_after(last_);
    while (ticks_.waiting() > wanted + slack)
        ticks_.pop([this](const HeardTick& tick) { last_ = merged(last_, tick); });
    bridged_ = 0;
    return last_;
}

void HeardTicks::fill(std::span<StereoSample> samples) {
    if (!std::exchange(begun_, true))
        for (std::size_t early = ticks_.waiting(); early > 0; --early) ticks_.pop([](const HeardTick&) {});
    for (std::size_t k = 0; k < samples.size(); ++k) {
        if (played_ == samples_.size()) {
            sound_.render(next((samples.size() - k) / samples_.size()), *clip_, samples_);
            played_ = 0;
        }
        samples[k] = samples_[played_++];
    }
}

void FilmedSound::render(const HeardTick& tick, ClipSound& clip) {
    sound_.render(tick, clip, samples_);
    keep_(next_ms_++ * ContactSound::samples_per_tick, samples_);
}

void FilmedSound::skip_to(std::int64_t now_ms, const HeardTick& tick, ClipSound& clip) {
    const HeardTick silence = silence_after(tick);
    for (std::int64_t k = 0; k < fade_ms && next_ms_ < now_ms; ++k) render(silence, clip);
    next_ms_ = std::max(next_ms_, now_ms);
}

/// Ticks are not placed before their time. A tick that would be placed later than now follows one that came
/// late: it is dropped, except for its events.
void FilmedSound::consume(const HeardTick& tick, std::int64_t passed, ClipSound& clip, std::int64_t now_ms) {
    if (aligns_.exchange(false, std::memory_order_relaxed) || passed > longest_skip_ms)
        skip_to(now_ms, tick, clip);
    else
        for (std::int64_t k = passed; k > 1; --k) render(going_on(tick), clip);
    const HeardTick now = early_ ? merged(*early_, tick) : tick;
    early_.reset();
    if (next_ms_ > now_ms)
        early_ = now;
    else
        render(now, clip);
}

}  // namespace touchable
