#pragma once

#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// Whether a file is the text of an MPEG-4 scene, as its first word tells.
bool is_scene_text(const SourceFile& file);

/// A touchable clip whose MPEG-4 scene is text, beside the pictures or videos that it names (docs/mpeg4.md).
/// They lie in its folder or below; nothing is fetched from elsewhere. `described` stands in place of what it
/// says of them.
Result<std::unique_ptr<ClipReader>> open_scene_text(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    Colour colour = Colour::wanted);

}  // namespace touchable
