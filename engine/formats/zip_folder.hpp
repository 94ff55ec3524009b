// SPDX-License-Identifier: Apache-2.0
#pragma once

// A ZIP archive of pictures is unpacked into a private temporary folder (ScratchFolder), which is opened as a
// clip and removed with it. Messages name the archive instead of that folder.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {

/// The folder that an archive was unpacked to.
class ZipFolder : NonCopyable {
public:
    /// Unpacks the members that a clip may need: pictures, videos, and files that may describe them. An error
    /// if the archive is damaged or encrypted, a member's name leads out of it or 64 folders deep, or the
    /// members take more than 10,000 folders or 16 GiB, or leave less than 1 GiB free on the temporary disk.
    /// `inner`: the folder to unpack; empty: all.
    static Result<std::shared_ptr<ZipFolder>> unpack(const std::filesystem::path& archive,
                                                     const std::filesystem::path& inner);

    const std::filesystem::path& archive() const { return archive_; }
    /// The folder to open: the one with the depth pictures, or the one that all members are in.
    const std::filesystem::path& opened() const { return opened_; }
    /// Whether a path leads into the temporary folder.
    bool has(const std::filesystem::path& file) const;
    /// Returns a message with the temporary folder's name replaced by the archive's.
    std::string named(std::string message) const;
    Error named(Error error) const {
        error.message = named(std::move(error.message));
        return error;
    }

private:
    explicit ZipFolder(std::filesystem::path archive) : archive_(std::move(archive)) {}
    Result<void> fill(const std::filesystem::path& inner);

    std::filesystem::path archive_;
    std::unique_ptr<ScratchFolder> temporary_{};
    std::filesystem::path root_{};  ///< in temporary_, named as the archive
    std::filesystem::path opened_{};
};

/// The archive of pictures that a path names, and the folder in it that the rest of the path names, if any.
/// Nothing for other paths, and for an archive with NumPy arrays alone (.npz).
struct ZipPlace {
    std::filesystem::path archive, inner{};
};
std::optional<ZipPlace> zip_of_pictures(const std::filesystem::path& path);

/// Makes the clip keep the folder that it is read from, and have the archive as its input file.
std::unique_ptr<ClipReader> with_zip_folder(std::unique_ptr<ClipReader> clip,
                                            std::shared_ptr<ZipFolder> folder);

}  // namespace touchable
