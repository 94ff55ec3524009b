#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// One frame as a static MPEG-4 scene in one MP4 file (docs/mpeg4.md): each plane is a track with one PNG
/// picture, which keeps every value, also of 16 bits. What nodes cannot say is in the scene as a scene file's
/// text.
Result<std::unique_ptr<ClipWriter>> create_mp4_stills(const std::filesystem::path& path,
                                                      const SceneDescription& described, Existing existing);

}  // namespace touchable
