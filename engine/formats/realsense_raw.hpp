#pragma once

// A snapshot of the RealSense Viewer: NAME_Depth.raw has the codes of a depth picture, without a header, and
// NAME_Depth_metadata.csv beside it states its size and camera. (NAME_Depth.png is that picture in false
// colours, from which depth cannot be restored.) Functions of the file system, for any thread.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// The metadata beside a file NAME.raw; nothing if there is none.
std::optional<std::filesystem::path> realsense_metadata_of(const std::filesystem::path& raw);
/// The depth snapshot in a folder that has exactly one and no other depth pictures; otherwise nothing.
std::optional<std::filesystem::path> realsense_snapshot_in(const std::filesystem::path& folder);

/// The camera and picture size in the metadata. An error if either is missing, or if the format is not 16-bit
/// depth (Z16). Messages begin with `where`.
Result<Intrinsics> parse_realsense_metadata(std::string_view text, const std::string& where);
Result<Intrinsics> read_realsense_metadata(const std::filesystem::path& metadata);

/// Reads a snapshot's depth picture. An error if the file's length does not match the size in the metadata.
Result<StoredImage> read_realsense_raw(const SourceFile& raw);

}  // namespace touchable
