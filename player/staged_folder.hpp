#pragma once

#include <filesystem>
#include <span>

#include "engine/result.hpp"

namespace touchable {

/// A folder whose files appear together: they are written beside their place and moved there by `commit`.
/// Without it nothing is left behind.
class StagedFolder {
public:
    /// `place`: where the files shall be; made, with its parents, where it does not exist.
    static Result<StagedFolder> create(const std::filesystem::path& place);
    StagedFolder(StagedFolder&& other) noexcept;
    StagedFolder& operator=(StagedFolder&&) = delete;
    ~StagedFolder();

    /// Write here.
    const std::filesystem::path& path() const { return staging_; }
    /// Moves the files named to their place; of those not written, one that an earlier run left there is
    /// removed.
    Result<void> commit(std::span<const char* const> names);

private:
    StagedFolder(std::filesystem::path place, std::filesystem::path first_made);
    std::filesystem::path place_, staging_;
    std::filesystem::path first_made_;  ///< topmost folder that did not exist before; empty: all did
};

}  // namespace touchable
