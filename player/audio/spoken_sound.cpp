#include "player/audio/spoken_sound.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/base/given_file.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/sound_track.hpp"

namespace touchable {
namespace {

constexpr std::size_t samples_read = 4096;

std::array<std::int16_t, 2> in_16_bits(const StereoSample& sample) {
    const auto whole = [](float value) {
        const float bounded = std::isfinite(value) ? std::clamp(value, -1.0F, 1.0F) : 0;
        return static_cast<std::int16_t>(std::lround(bounded * 32767));
    };
    return {whole(sample.left), whole(sample.right)};
}

}  // namespace

/// A track does not say how long it is: behind its end it is silent.
Result<std::shared_ptr<const SpokenSound>> SpokenSound::read(const std::filesystem::path& file) {
    const auto refuse = [&file](const std::string& why) {
        return input_error(file.string() + ": " + why +
                           "; right would be a sound of up to 60 s, such as a WAV file");
    };
    if (const auto there = GivenFile::open(file, file.string(), "a sound of up to 60 s, such as a WAV file");
        !there.ok())
        return there.error();
    TRY_ASSIGN(const auto track, SoundTrack::open(file));
    if (!track) return refuse("has no sound");
    auto sound = std::make_shared<SpokenSound>();
    const auto most = static_cast<std::size_t>(longest_s * SoundTrack::rate);
    std::size_t end = 0;  // behind the last that is heard
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
    constexpr float rise = 1.0F / 96, soften = 1.0F / 2400;  // shares of a sample: 2 ms and 50 ms
    const bool is_another = sound && number != number_;
    if (!is_another && !sound_ && others_ == 1) return;
    for (StereoSample& sample : to) {
        // What is said fades before another one begins.
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

}  // namespace touchable
