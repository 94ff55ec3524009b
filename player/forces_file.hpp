#pragma once

#include <filesystem>
#include <fstream>
#include <memory>

#include "engine/media/new_file.hpp"
#include "player/touch_session.hpp"

namespace touchable {

/// `--forces FILE`: a header, then one row per tick and finger with all it takes to check a force with
/// another program. World axes, scene units, newtons, N/m; numbers to 17 digits, so exactly the bits that
/// were felt.
class ForcesFile final : public TouchSink {
public:
    static Result<std::unique_ptr<ForcesFile>> create(const std::filesystem::path& file);
    Result<void> take(const TouchTick& tick) override;
    /// Gives the file its name; without this nothing is left behind.
    Result<void> finish();

private:
    explicit ForcesFile(const std::filesystem::path& file) : file_(file) {}
    Error failed() const;

    NewFile file_;
    std::ofstream out_;
    std::string row_;
};

}  // namespace touchable
