#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "player/session/output_file.hpp"
#include "player/session/touch_session.hpp"

namespace touchable {

/// `--forces FILE`, or `-` for standard output: a header, then one row per tick and finger with all it takes
/// to check a force with another program. World axes, scene units, newtons, N/m; numbers to 17 digits, so
/// exactly the bits that were felt.
class ForcesFile final : public TouchSink {
public:
    static Result<std::unique_ptr<ForcesFile>> create(const std::filesystem::path& file, Existing existing);
    Result<void> take(const TouchTick& tick) override;
    /// Gives the file its name; without this nothing is left behind.
    Result<void> finish() { return file_->finish(); }
    std::string name() const { return file_->name(); }  ///< as OutputFile has it

private:
    explicit ForcesFile(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}

    std::unique_ptr<OutputFile> file_;
    std::string rows_;  // of one tick
};

}  // namespace touchable
