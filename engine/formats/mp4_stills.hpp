#pragma once

#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// Whether an MP4 file's MPEG-4 scene is a static one in the same file: its depth is an ImageTexture, whose
/// track is a PNG or JPEG picture.
bool is_mp4_stills(const SourceFile& file);

/// Such a scene as a clip of one frame (docs/mpeg4.md). `described` stands in place of what it says of
/// itself.
Result<std::unique_ptr<ClipReader>> open_mp4_stills(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    Colour colour = Colour::wanted);

}  // namespace touchable
