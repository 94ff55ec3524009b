#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "player/run/output_sink.hpp"

namespace touchable {

/// `--forces FILE`, or `-` for standard output: a header, then one row per tick and finger with all it takes
/// to check a force with another program. World axes, scene units, newtons, N/m; numbers to 17 digits, so
/// exactly the bits that were felt.
class ForcesFile final : public OutputSink {
public:
    static Result<std::unique_ptr<ForcesFile>> create(const std::filesystem::path& file, Existing existing,
                                                      Pace pace, std::string name);
    /// Gives the file its name, as OutputFile does; without this nothing is left behind.
    Result<void> finish() { return file_->finish(); }

private:
    using OutputSink::OutputSink;
    Result<void> write(const TouchTick& tick) override;

    std::string rows_;  // of one tick
};

}  // namespace touchable
