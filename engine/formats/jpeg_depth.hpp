#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

// JPEG files with a depth map, as phones write them: in their XMP ("GDepth"), or as a picture after their own
// that their XMP describes ("Dynamic Depth").

/// Whether a JPEG's XMP speaks of a depth map, be it whole or not.
bool has_jpeg_depth(const SourceFile& file);

/// A clip of one frame as of open_depth_photo; the JPEG's own picture is its colour.
Result<std::unique_ptr<ClipReader>> open_jpeg_depth(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    const SourceDescription& known);

/// The contents of a JPEG's segments APP1, up to its picture. Nothing where a segment is cut.
std::optional<std::vector<std::string_view>> app1_segments(std::string_view jpeg);

/// Bytes of the first picture in a file, which others may follow. Nothing where its end is missing.
std::optional<std::size_t> jpeg_length(std::string_view file);

/// What a JPEG's EXIF says (parse_exif).
ExifFacts read_jpeg_exif(std::string_view jpeg);

/// The XMP of a JPEG file: its packet, and the extended packet that it names, put together from its pieces.
/// Empty where the file has none. Prefixes are taken as they stand, without their namespaces. Messages begin
/// with `where`.
Result<XmpProperties> read_jpeg_xmp(std::string_view jpeg, const std::string& where);
/// The same in order, the extended packet first.
Result<XmpEntries> read_jpeg_xmp_entries(std::string_view jpeg, const std::string& where);

/// The bytes of a Dynamic Depth JPEG's depth map, a picture after its own: found by the directory of its XMP,
/// which lists the pictures and their lengths. Messages begin with `where`.
Result<std::string_view> dynamic_depth_map(std::string_view jpeg, const XmpEntries& xmp,
                                           const std::string& where);

/// Its camera, of the picture as stored. Nothing where the XMP has none.
std::optional<Intrinsics> dynamic_depth_camera(const XmpProperties& xmp);

}  // namespace touchable
