#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// One frame as the paper sends a static scene: NAME.bt, the text of its MPEG-4 scene, beside the PNG
/// pictures that it names, NAME_depth.png and so on (docs/mpeg4.md). What nodes cannot say the text has as a
/// scene file's text.
Result<std::unique_ptr<ClipWriter>> create_scene_text(const std::filesystem::path& text,
                                                      const SceneDescription& described, Existing existing);

}  // namespace touchable
