// SPDX-License-Identifier: Apache-2.0
#include "player/audio/heard_sound.hpp"

#ifdef TOUCHABLE_HAS_ALSA

#include <alsa/asoundlib.h>

#include <string>
#include <thread>
#include <vector>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// Replaces ALSA's error handler, which prints to the terminal.
void say_nothing(const char*, int, const char*, int, const char*, ...) {}

Error alsa_error(const char* what, int code) {
    return device_error(std::string(what) + " (" + snd_strerror(code) + ")");
}

class AlsaSoundDevice final : public SoundDevice {
public:
    explicit AlsaSoundDevice(snd_pcm_t* pcm) : pcm_(pcm) {}
    ~AlsaSoundDevice() override {
        snd_pcm_drop(pcm_);
        snd_pcm_close(pcm_);
    }

    Result<bool> wait_for(int samples, std::chrono::milliseconds longest) override {
        TRY_ASSIGN(auto there, room());
        if (there >= samples) return true;
        const int waited = snd_pcm_wait(pcm_, static_cast<int>(longest.count()));
        if (waited < 0) TRY(mend(waited));
        TRY_ASSIGN(there, room());
        // Some devices report room at once, but have none.
        if (there < samples && waited > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return there >= samples;
    }

    Result<void> write(std::span<const StereoSample> samples) override {
        integers_.clear();
        for (const StereoSample& sample : samples) integers_.push_back(in_16_bits(sample));
        const auto written = snd_pcm_writei(pcm_, integers_.data(), samples.size());
        return written < 0 ? mend(static_cast<int>(written)) : Result<void>();
    }

private:
    /// Recovers from an underrun or the computer's sleep.
    Result<void> mend(int code) {
        if (code == -EAGAIN) return {};
        const int mended = snd_pcm_recover(pcm_, code, 1);
        return mended < 0 ? alsa_error("the device is gone", mended) : Result<void>();
    }
    Result<int> room() {
        const auto there = snd_pcm_avail_update(pcm_);
        if (there >= 0) return static_cast<int>(there);
        TRY(mend(static_cast<int>(there)));
        return 0;
    }

    snd_pcm_t* pcm_;
    std::vector<std::array<std::int16_t, 2>> integers_;
};

}  // namespace

Result<std::unique_ptr<SoundDevice>> SoundDevice::open() {
    snd_lib_error_set_handler(say_nothing);
    snd_pcm_t* pcm = nullptr;
    if (const int code = snd_pcm_open(&pcm, "default", SND_PCM_STREAM_PLAYBACK, SND_PCM_NONBLOCK); code < 0)
        return alsa_error("no device", code);
    std::unique_ptr<SoundDevice> device = std::make_unique<AlsaSoundDevice>(pcm);
    const int code = snd_pcm_set_params(pcm, SND_PCM_FORMAT_S16, SND_PCM_ACCESS_RW_INTERLEAVED, 2,
                                        ContactSound::rate, 1, buffer * 1'000'000U / ContactSound::rate);
    if (code < 0) return alsa_error("the device takes no 48 kHz", code);
    return device;
}

}  // namespace touchable

#else

namespace touchable {

Result<std::unique_ptr<SoundDevice>> SoundDevice::open() {
    return device_error("built without it (ALSA: libasound2-dev)");
}

}  // namespace touchable

#endif
