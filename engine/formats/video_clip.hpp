#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/aligned_clip.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/video_file.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// Whether a file's first 12 bytes are those of a container of videos: Matroska or WebM, QuickTime or MP4,
/// AVI.
bool begins_like_video(std::string_view begin);

/// The video, or the two, that the scene's VideoSource names in `folder`; `depth`: the first of them, where
/// it was opened already.
Result<std::unique_ptr<ClipReader>> open_video_clip(const std::filesystem::path& folder,
                                                    const SceneDescription& described,
                                                    Colour colour = Colour::wanted,
                                                    std::shared_ptr<VideoFile> depth = nullptr,
                                                    DepthAlignment alignment = DepthAlignment::automatic);

}  // namespace touchable
