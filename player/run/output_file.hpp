#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/new_file.hpp"
#include "player/run/pace.hpp"
#include "player/run/standard_output.hpp"

namespace touchable {

/// A file that somebody asked for (`--json FILE`), or standard output (`--json -`). A file is opened before
/// the work that fills it, so that a place where nothing can be written is known at once, and has its name
/// only when it is complete: whatever goes wrong leaves nothing behind, and an older file as it was. Where
/// the disk is full, a run by the wall clock keeps the pieces that are whole by then.
class OutputFile {
public:
    /// `what`: for messages, as whoever asked for it calls it: "--forces", "the recording". An error of kind
    /// input where nothing can be written there.
    static Result<std::unique_ptr<OutputFile>> create(std::string what, const std::filesystem::path& file,
                                                      Existing existing, Pace pace = Pace::own);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// What is whole together or not there. After an error nothing more is taken.
    Result<void> write(std::string_view piece);
    /// For messages: "--forces f.csv", "the recording f.touch".
    std::string name() const;
    Pace pace() const { return pace_; }
    /// Gives the file its name. Nothing may be written after that. An error where anything is missing; by the
    /// wall clock the file is there nevertheless, with the pieces before, where there are two or more.
    Result<void> finish();
    /// Whether what went wrong is that nobody reads standard output, or not fast enough.
    bool reader_lags() const { return standard_ && standard_->reader_lags(); }

    // For who knows how such a file ends, also earlier than it was to.
    /// Writes out what waits for more.
    Result<void> flush();
    /// Bytes of the pieces that are whole.
    std::uint64_t size() const { return size_; }
    /// Other bytes for some that stand there.
    Result<void> write_over(std::uint64_t at, std::string_view bytes);
    /// What stands there; empty where it cannot be read.
    std::string read(std::uint64_t at, std::size_t size) const;
    /// Only the first `size` bytes, and what is written from now on.
    Result<void> go_on_from(std::uint64_t size);
    /// Gives it its name as it is.
    Result<void> keep();

private:
    OutputFile(std::string what, const std::filesystem::path& file, Existing existing, Pace pace);
    Error failed(int why) const;
    int write_out();

    std::string what_;
    Pace pace_;
    std::optional<NewFile> file_;
    std::optional<StandardOutput> standard_;  ///< in place of a file
    int out_ = -1;
    std::string waiting_;            // of the file, until there is enough to write
    std::vector<std::size_t> ends_;  // of the pieces in it
    std::uint64_t size_ = 0;         // of the file
    std::size_t pieces_ = 0;         // in it
    std::optional<Error> fault_;
};

/// Of outputs that are finished each for itself: what went wrong first, and behind it what else did.
Result<void> all_ok(const std::vector<Result<void>>& finished);

}  // namespace touchable
