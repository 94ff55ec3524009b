#include "player/window/sound_file.hpp"

#include <array>
#include <cmath>
#include <cstring>

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

}  // namespace

Result<std::unique_ptr<SoundFile>> SoundFile::create(const std::filesystem::path& file, Existing existing) {
    std::unique_ptr<SoundFile> made(new SoundFile(file, existing));
    if (auto free = made->file_.check(); !free.ok()) return free.error();
    made->out_.open(made->file_.path(), std::ios::binary);
    made->write_header();
    if (!made->out_)
        return Error{ErrorKind::input, "--sound " + file.string() + ": nothing can be written there"};
    return made;
}

void SoundFile::write_header() {
    std::string header = "RIFF";
    put(header, header_bytes - 8 + bytes_, 4);
    header += "WAVEfmt ";
    put(header, 16, 4);  // bytes of what follows
    put(header, 1, 2);   // integers
    put(header, 2, 2);   // channels
    put(header, ContactSound::rate, 4);
    put(header, ContactSound::rate * sample_bytes, 4);
    put(header, sample_bytes, 2);
    put(header, 16, 2);  // bits
    header += "data";
    put(header, bytes_, 4);
    out_.write(header.data(), static_cast<std::streamsize>(header.size()));
}

void SoundFile::add(std::span<const StereoSample> samples) {
    const auto bytes = static_cast<std::uint32_t>(samples.size()) * sample_bytes;
    if (bytes > most_wav_bytes - bytes_) return;
    std::string words;
    words.reserve(bytes);
    for (const StereoSample& sample : samples) {
        put(words, sample.left);
        put(words, sample.right);
    }
    out_.write(words.data(), static_cast<std::streamsize>(words.size()));
    bytes_ += bytes;
}

Result<void> SoundFile::finish() {
    out_.seekp(0);
    write_header();
    out_.close();
    if (!out_)
        return Error{ErrorKind::input,
                     "--sound " + file_.target().string() + ": it cannot be written; is the disk full?"};
    return file_.commit();
}

}  // namespace touchable
