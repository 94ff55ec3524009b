#include "player/audio/sound_file.hpp"

#include <array>
#include <cmath>
#include <string>

namespace touchable {
namespace {

constexpr std::uint32_t header_bytes = 44, sample_bytes = 4;
constexpr std::uint32_t most_wav_bytes = 0xFFFFFFFFU - header_bytes - sample_bytes;

void put(std::string& to, std::uint32_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> (8 * k) & 0xFFU);
}

void put(std::string& to, float value) {
    put(to, static_cast<std::uint32_t>(std::lround(value * 32767)), 2);
}

std::string header_of(std::uint32_t bytes) {
    std::string header = "RIFF";
    put(header, header_bytes - 8 + bytes, 4);
    header += "WAVEfmt ";
    put(header, 16, 4);  // bytes of what follows
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

}  // namespace

Result<std::unique_ptr<SoundFile>> SoundFile::create(const std::filesystem::path& file, Existing existing) {
    auto opened = OutputFile::create("--sound", file, existing, Pace::wall_clock);
    if (!opened.ok()) return opened.error();
    std::unique_ptr<SoundFile> made(new SoundFile(std::move(*opened)));
    if (auto begun = made->file_->write(header_of(0)); !begun.ok()) return begun.error();
    return made;
}

void SoundFile::add(std::span<const StereoSample> samples) {
    const auto bytes = static_cast<std::uint32_t>(samples.size()) * sample_bytes;
    if (is_faulty_ || bytes > most_wav_bytes - bytes_) return;
    words_.clear();
    for (const StereoSample& sample : samples) {
        put(words_, sample.left);
        put(words_, sample.right);
    }
    bytes_ += bytes;
    const auto written = file_->write(words_);
    if (written.ok()) return;
    is_faulty_ = true;
    const std::lock_guard lock(mutex_);
    fault_ = written.error();
}

std::optional<Error> SoundFile::fault() const {
    const std::lock_guard lock(mutex_);
    return fault_;
}

Result<void> SoundFile::finish() {
    const auto whole = file_->flush();
    if (!whole.ok() && file_->size() <= header_bytes) return whole;
    const auto samples = static_cast<std::uint32_t>(file_->size()) - header_bytes;
    if (auto begun = file_->write_over(0, header_of(samples)); !begun.ok()) return begun;
    return file_->finish();
}

}  // namespace touchable
