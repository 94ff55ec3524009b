#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "engine/clip/clip_reader.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// By a file's first 12 bytes.
bool is_heif(std::string_view begin);

/// A HEIC, HEIF or AVIF photograph with an auxiliary picture of depth, as iPhones write portraits. A clip of
/// one frame as of open_depth_photo.
Result<std::unique_ptr<ClipReader>> open_heic_image(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    const SourceDescription& known);

}  // namespace touchable
