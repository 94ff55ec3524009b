// SPDX-License-Identifier: Apache-2.0
#include "player/audio/window_sound.hpp"

#include <future>
#include <glm/geometric.hpp>

#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "player/run/run_files.hpp"

namespace touchable {
namespace {

constexpr std::uint32_t header_bytes = 44, sample_bytes = 4;
constexpr std::uint32_t most_wav_bytes = 0xFFFFFFFFU - header_bytes - sample_bytes;

void put(std::string& to, std::uint32_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> (8 * k) & 0xFFU);
}

std::string header_of(std::uint32_t bytes) {
    std::string header = "RIFF";
    put(header, header_bytes - 8 + bytes, 4);
    header += "WAVEfmt ";
    put(header, 16, 4);  // bytes of the format block
    put(header, 1, 2);   // integers
    put(header, 2, 2);   // channels
    put(header, ContactSound::rate, 4);
    put(header, ContactSound::rate * sample_bytes, 4);
    put(header, sample_bytes, 2);
    put(header, 16, 2);  // bits
    header += "data";
    put(header, bytes, 4);
    return header;
}

constexpr std::int64_t longest_gap = 1000;  // ticks; a longer gap means that the computer slept

}  // namespace

/// ALSA's "default" device, which may be PipeWire or PulseAudio, opened and fed by a separate thread. The
/// window does not wait for it, and its absence is no error.
class WindowSound::Loudspeakers : NonCopyable {
public:
    explicit Loudspeakers(std::shared_ptr<HeardTicks> ticks) : shared_(std::make_shared<Shared>()) {
        shared_->ticks = std::move(ticks);
        std::promise<void> ended;
        ended_ = ended.get_future();
        const auto begun = start_thread(thread_, "sound-output", "of the sound",
                                        [shared = shared_, ended = std::move(ended)]() mutable {
                                            shared->open_and_play();
                                            ended.set_value();
                                        });
        if (!begun) shared_->say("no sound: " + begun.error().message);
    }
    /// Abandons a thread that hangs in the system's sound, after a second.
    ~Loudspeakers() {
        if (!thread_.joinable()) return;
        shared_->stopping.store(true, std::memory_order_relaxed);
        if (ended_.wait_for(std::chrono::seconds(1)) == std::future_status::ready)
            thread_.join();
        else
            thread_.detach();
    }

    /// "sound on", or why there is none. Any thread.
    std::string state() const {
        const std::lock_guard lock(shared_->mutex);
        return shared_->state;
    }

private:
    /// Shared with the thread, which may outlive this.
    struct Shared {
        std::shared_ptr<HeardTicks> ticks;
        std::atomic<bool> stopping{false};
        mutable std::mutex mutex;
        std::string state = "sound is being opened";

        void say(std::string words) {
            const std::lock_guard lock(mutex);
            state = std::move(words);
        }
        void open_and_play() {
            auto device = SoundDevice::open();
            if (!device) return say("no sound: " + device.error().message);
            say("sound on");
            if (auto played = play(**device); !played) say("no sound any more: " + played.error().message);
        }
        /// Runs until stopped. Some ALSA outputs accept everything at once: the rate is limited to 1 % above
        /// real time, more than a real device's clock is fast.
        Result<void> play(SoundDevice& device) {
            using Clock = std::chrono::steady_clock;
            constexpr int block = 240;  // 5 ms
            constexpr std::chrono::milliseconds patience(100);
            std::vector<StereoSample> samples(block);
            const auto begun = Clock::now();
            double written = 0;
            while (!stopping.load(std::memory_order_relaxed)) {
                const double passed = std::chrono::duration<double>(Clock::now() - begun).count();
                if (written > 1.01 * ContactSound::rate * passed + SoundDevice::buffer) {
                    std::this_thread::sleep_for(std::chrono::milliseconds(2));
                    continue;
                }
                TRY_ASSIGN(const auto ready, device.wait_for(block, patience));
                if (!ready) continue;
                ticks->fill(samples);
                TRY(device.write(samples));
                written += block;
            }
            return {};
        }
    };

    std::shared_ptr<Shared> shared_;
    std::future<void> ended_;
    std::thread thread_;
};

/// A WAV file: two channels of 16 bits at 48 kHz. It gets its name once it is complete, or as complete as a
/// full disk allows.
class WindowSound::WavFile {
public:
    /// Fails (ErrorKind::input) if the file cannot be written.
    static Result<std::unique_ptr<WavFile>> create(const std::filesystem::path& file, Existing existing,
                                                   std::string name) {
        TRY_ASSIGN(auto opened, OutputFile::create(std::move(name), file, existing, Pace::wall_clock));
        TRY(opened->write(header_of(0)));
        return std::unique_ptr<WavFile>(new WavFile(std::move(opened)));
    }
    /// Drops samples beyond a WAV file's maximum, which is reached after six hours.
    void add(std::span<const StereoSample> samples) {
        const auto bytes = static_cast<std::uint32_t>(samples.size()) * sample_bytes;
        if (fault_ || bytes > most_wav_bytes - bytes_) return;
        words_.clear();
        for (const StereoSample& sample : samples)
            for (const std::int16_t value : in_16_bits(sample))
                put(words_, static_cast<std::uint16_t>(value), 2);
        bytes_ += bytes;
        const auto written = file_->write(words_);
        if (written) return;
        const std::lock_guard lock(mutex_);
        fault_ = written.error();
    }
    /// Why writing stopped; any thread.
    std::optional<Error> fault() const {
        const std::lock_guard lock(mutex_);
        return fault_;
    }
    /// Gives the file its name. Fails if anything could not be written.
    Result<void> finish() {
        const auto whole = file_->flush();
        if (!whole && file_->size() <= header_bytes) return whole;
        TRY(file_->write_over(0, header_of(static_cast<std::uint32_t>(file_->size()) - header_bytes)));
        return file_->finish();
    }

private:
    explicit WavFile(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}

    const std::unique_ptr<OutputFile> file_;
    std::uint32_t bytes_ = 0;  // of samples
    std::string words_;
    mutable std::mutex mutex_;
    std::optional<Error> fault_;  // `add` alone writes it, under mutex_
};

WindowSound::WindowSound() = default;
WindowSound::~WindowSound() = default;

std::optional<Error> WindowSound::file_fault() const {
    return file_ ? file_->fault() : std::nullopt;
}

Result<std::unique_ptr<WindowSound>> WindowSound::create(bool loudspeakers,
                                                         const std::optional<std::filesystem::path>& file,
                                                         Existing existing, std::string name) {
    std::unique_ptr<WindowSound> made(new WindowSound);
    if (file) TRY(assign(made->file_, WavFile::create(*file, existing, std::move(name))));
    if (loudspeakers) made->output_ = std::make_unique<Loudspeakers>(made->ticks_);
    return made;
}

void WindowSound::consume(HeardTick tick, std::int64_t passed) {
    tick.muted = is_muted();
    const float share = static_cast<float>(volume()) / 100;
    tick.loudness = share * share * share;
    if (fingers_silent_.load(std::memory_order_relaxed)) tick.fingers = {};
    if (const Said said = said_.load(std::memory_order_relaxed); said.number != 0) {
        tick.spoken = spoken_[said.sound].get();
        tick.spoken_number = said.number;
    }
    if (rumble_) rumble_->consume(tick);
    if (output_) ticks_->push(tick);
    if (is_filmed_.load(std::memory_order_acquire)) film_->consume(tick, passed, *clip_, film_now_ms_());
    if (!file_) return;
    for (std::int64_t k = std::min(passed, longest_gap); k > 1; --k) {
        kept_.render(going_on(tick), *clip_, samples_);
        file_->add(samples_);
    }
    kept_.render(tick, *clip_, samples_);
    file_->add(samples_);
}

void WindowSound::film(FilmedSound::Keep keep, std::function<std::int64_t()> now_ms) {
    film_.emplace(std::move(keep));
    film_now_ms_ = std::move(now_ms);
    is_filmed_.store(true, std::memory_order_release);
}

void WindowSound::set_spoken(std::vector<std::shared_ptr<const SpokenSound>> sounds) {
    spoken_ = std::move(sounds);
    ticks_->keep(spoken_);
}

void WindowSound::say(std::size_t sound) {
    if (sound >= spoken_.size() || !spoken_[sound]) return;
    const std::uint32_t number = said_.load(std::memory_order_relaxed).number + 1;
    said_.store({number, static_cast<std::uint32_t>(sound)}, std::memory_order_relaxed);
}

std::string WindowSound::state() const {
    if (is_muted()) return "sound off";
    if (std::string fault = clip_->fault(); !fault.empty()) return fault;
    return output_ ? output_->state() : "no sound without a window";
}

Result<void> WindowSound::finish() {
    return file_ ? file_->finish() : Result<void>();
}

HeardClip TouchListener::hear_clip(std::int64_t tick) {
    const PlaybackState state = clock_->state_at(tick);
    return {state.playing && state.moment.time_ns < end_ns_, state.moment.time_ns, state.moment.epoch,
            static_cast<float>(static_cast<double>(state.rate) / 1000)};
}

Result<void> TouchListener::consume(const TouchTick& tick) {
    HeardTick heard = contacts_.hear(tick);
    const std::int64_t passed = tick.tick - last_tick_;
    last_tick_ = tick.tick;
    if (!begun_.load(std::memory_order_acquire)) return {};
    heard.clip = hear_clip(tick.tick);
    sound_.consume(heard, passed);
    return {};
}

}  // namespace touchable
