#pragma once

// A snapshot of the RealSense Viewer: NAME_Depth.raw has the codes of a picture of depth, without a head, and
// NAME_Depth_metadata.csv beside it has its size and its camera. (NAME_Depth.png is that picture in colours,
// from which depth cannot be had again.) Functions of the file system, for any thread.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// The metadata beside a file NAME.raw; nothing where there is none.
std::optional<std::filesystem::path> realsense_metadata_of(const std::filesystem::path& raw);
/// The snapshot of depth in a folder, where there is exactly one, and no other pictures of depth.
std::optional<std::filesystem::path> realsense_snapshot_in(const std::filesystem::path& folder);

/// The camera that metadata state, with the size of its pictures. Refused where that or the camera is
/// missing, and where the pictures are not depth of 16 bits (Z16). Messages begin with `where`.
Result<Intrinsics> parse_realsense_metadata(std::string_view text, const std::string& where);
Result<Intrinsics> read_realsense_metadata(const std::filesystem::path& metadata);

/// Its picture of depth. Refused where the file is not as long as the metadata say.
Result<StoredImage> read_realsense_raw(const SourceFile& raw);

}  // namespace touchable
