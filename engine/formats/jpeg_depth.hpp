#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// Whether a JPEG's XMP speaks of a depth map, be it whole or not.
bool has_jpeg_depth(const SourceFile& file);

/// A JPEG with a depth map, as phones write it: in its XMP ("GDepth"), or as a picture after its own that its
/// XMP describes ("Dynamic Depth"). A clip of one frame as of open_depth_photo; the JPEG's own picture is its
/// colour.
Result<std::unique_ptr<ClipReader>> open_jpeg_depth(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    const SourceDescription& known);

}  // namespace touchable
