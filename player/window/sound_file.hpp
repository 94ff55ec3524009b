#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>

#include "engine/new_file.hpp"
#include "engine/result.hpp"
#include "player/window/contact_sound.hpp"

namespace touchable {

/// A WAV file: two channels of 16 bits at 48 kHz. It has its name once it is complete.
class SoundFile {
public:
    /// An error (ErrorKind::input) where nothing can be written there.
    static Result<std::unique_ptr<SoundFile>> create(const std::filesystem::path& file, Existing existing);
    /// What does not fit into a WAV file, after six hours, is left out.
    void add(std::span<const StereoSample> samples);
    /// Gives the file its name. An error where anything could not be written.
    Result<void> finish();

private:
    SoundFile(const std::filesystem::path& file, Existing existing) : file_(file, existing) {}
    void write_header();

    NewFile file_;
    std::ofstream out_;
    std::uint32_t bytes_ = 0;  // of samples
};

}  // namespace touchable
