#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/new_file.hpp"

namespace touchable {

/// A file that an option asked for (`--json FILE`), or standard output (`--json -`). A file is opened before
/// the work that fills it, so that a place where nothing can be written is known at once, and has its name
/// only when it is complete: whatever goes wrong leaves nothing behind, and an older file as it was.
class OutputFile {
public:
    /// `option`: as typed, for messages. An error of kind input where nothing can be written there.
    static Result<std::unique_ptr<OutputFile>> create(std::string option, const std::filesystem::path& file,
                                                      Existing existing);
    Result<void> write(std::string_view bytes);
    /// For messages: "--forces f.csv", "--forces -".
    std::string name() const;
    /// Gives the file its name. Nothing may be written after that.
    Result<void> finish();

private:
    OutputFile(std::string option, const std::filesystem::path& file, Existing existing);
    Error failed() const;

    std::string option_;
    std::optional<NewFile> file_;  ///< nothing: standard output
    std::ofstream out_;
};

/// Of a live run whose ticks did not wait for a file (OutputFile::name), or, where that is empty, for the
/// program.
Error fell_behind_error(const std::string& files, std::int64_t ticks_missing);

}  // namespace touchable
