#pragma once

#include <memory>
#include <optional>

#include "engine/clip/clip_reader.hpp"
#include "engine/given_file.hpp"

namespace touchable {

/// A touchable clip in Matroska; `described` replaces the scene attached to it.
Result<std::unique_ptr<ClipReader>> open_matroska_clip(const SourceFile& file,
                                                       const std::optional<SceneDescription>& described,
                                                       Colour colour = Colour::wanted);

/// The same in MP4, or any MP4 file whose MPEG-4 scene is a touchable clip (docs/mpeg4.md).
Result<std::unique_ptr<ClipReader>> open_mp4_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  Colour colour = Colour::wanted);
/// Whether a file is one of these: it has tags of ours or an MPEG-4 scene.
bool is_mp4_clip(const SourceFile& file);

}  // namespace touchable
