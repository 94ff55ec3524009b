#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "engine/result.hpp"
#include "player/audio/contact_sound.hpp"
#include "player/record/output_file.hpp"

namespace touchable {

/// A WAV file: two channels of 16 bits at 48 kHz. It has its name once it is complete, or as complete as a
/// disk that became full let it be.
class SoundFile {
public:
    /// An error (ErrorKind::input) where nothing can be written there.
    static Result<std::unique_ptr<SoundFile>> create(const std::filesystem::path& file, Existing existing);
    /// What does not fit into a WAV file, after six hours, is left out.
    void add(std::span<const StereoSample> samples);
    /// Why nothing more is added; any thread.
    std::optional<Error> fault() const;
    /// Gives the file its name. An error where anything could not be written.
    Result<void> finish();

private:
    explicit SoundFile(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}

    const std::unique_ptr<OutputFile> file_;
    std::uint32_t bytes_ = 0;  // of samples
    std::string words_;
    bool is_faulty_ = false;
    mutable std::mutex mutex_;
    std::optional<Error> fault_;  // guarded by it
};

}  // namespace touchable
