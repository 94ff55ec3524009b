#pragma once

// A ZIP archive of pictures, which is opened as the folder that it unpacks to: a private folder of temporary
// files, which goes with the clip. Messages speak of the archive in place of that folder.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {

/// What an archive unpacked to, removed with it by the process that unpacked it.
class ZipFolder : NonCopyable {
public:
    /// Members that can be of a clip: pictures, videos, and what may describe them. Refused are archives that
    /// are damaged or encrypted, members that lead out of them, and what takes more than 16 GiB or leaves the
    /// disk of temporary files less than 1 GiB. `inner`: the folder in it to unpack; empty: all of it.
    static Result<std::shared_ptr<ZipFolder>> unpack(const std::filesystem::path& archive,
                                                     const std::filesystem::path& inner);
    ~ZipFolder();

    const std::filesystem::path& archive() const { return archive_; }
    /// The folder to open: the one with the pictures of depth, or that all members are in.
    const std::filesystem::path& opened() const { return opened_; }
    /// Whether a path leads into it.
    bool has(const std::filesystem::path& file) const;
    /// A message, with the archive's name in place of that of the folder.
    std::string named(std::string message) const;
    Error named(Error error) const {
        error.message = named(std::move(error.message));
        return error;
    }

private:
    explicit ZipFolder(std::filesystem::path archive) : archive_(std::move(archive)) {}
    Result<void> fill(const std::filesystem::path& inner);

    std::filesystem::path archive_;
    std::filesystem::path temporary_{};  ///< empty: not made
    std::filesystem::path root_{};       ///< in it, by the archive's name
    std::filesystem::path opened_{};
    int owner_ = 0;  ///< the process
};

/// The archive of pictures that a path names, and the folder in it that the path goes on with, if any.
/// Nothing where it names no such archive. An archive with arrays of NumPy alone (.npz) is none.
struct ZipPlace {
    std::filesystem::path archive, inner{};
};
std::optional<ZipPlace> zip_of_pictures(const std::filesystem::path& path);

/// The clip with the folder that it is read from, which it keeps; its files are the archive.
std::unique_ptr<ClipReader> with_zip_folder(std::unique_ptr<ClipReader> clip,
                                            std::shared_ptr<ZipFolder> folder);

}  // namespace touchable
