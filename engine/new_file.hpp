#pragma once

#include <filesystem>

#include "engine/result.hpp"

namespace touchable {

/// A file being written beside its target under another name: it takes the target's name when it is complete,
/// and is removed where it never becomes so.
class NewFile {
public:
    explicit NewFile(std::filesystem::path target);
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    const std::filesystem::path& target() const { return target_; }
    /// Where to write until `commit`. Closed by whoever opened it before that.
    const std::filesystem::path& path() const { return path_; }
    /// Refuses a target that is a folder or a device: only a file is ever replaced. `commit` looks again.
    Result<void> check_target() const;
    Result<void> commit();

private:
    std::filesystem::path target_, path_;
    bool committed_ = false;
};

}  // namespace touchable
