#pragma once

// Recordings, archives and containers of other programs that are not opened, but recognised: by their first
// bytes, or by their name if the bytes say less. One sentence for each says what the file is and what to do
// with it. Pure functions of the file system, for any thread.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// What a file is and what to do, as the end of a sentence that begins with its name: "is a Git LFS pointer
/// ...: git lfs pull". Nothing for a kind of file that is not known here.
std::optional<std::string> foreign_file(const SourceFile& file);

/// The same for files that one of our readers would mistake for its own: SVO2 is MCAP inside, a Git LFS
/// pointer has the name of the file that it stands for, and .npz are ZIP files. `begin`: the file's first 16
/// bytes, or all; unless these fit such a file, nothing more is read.
std::optional<std::string> misleading_file(const SourceFile& file, std::string_view begin);

/// The same for a folder that other programs treat as one file (.zarr).
std::optional<std::string> foreign_folder(const std::filesystem::path& folder);

/// A projection that no pinhole camera has.
struct Projection {
    std::string name{};      ///< "a cube map"
    std::string evidence{};  ///< "as its name says"; empty: depth's values alone, which may deceive
    std::string way{};       ///< how Python makes a view of it that opens
    Hints hints{};           ///< of that view
};
/// The projection of a picture of depth, with colour beside it (empty: none): an equirectangular panorama by
/// its XMP (ReadPictures::has_panorama), or if it is twice as wide as high by its name or its values; a cube
/// map, a fisheye picture or a cylinder's by its shape and name, the latter unless a file has its camera. A
/// name is its own or one of the two folders' that it is in. Nothing for a pinhole camera's, as far as is
/// known.
std::optional<Projection> projection_of(const StoredImage& picture, const std::filesystem::path& depth,
                                        const std::filesystem::path& colour, bool has_xmp, bool has_camera);

/// The first foreign file by name in a folder or up to three folders below it: "NAME is ...". Looks at 10000
/// entries and opens 64 files at most.
std::optional<std::string> foreign_file_below(const std::filesystem::path& folder);

}  // namespace touchable
