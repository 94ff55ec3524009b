#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// The name of a Depthkit video's description: "Test.Metadata.asset" for "Test.mov".
std::filesystem::path depthkit_metadata_name(const std::filesystem::path& video);
/// The description beside a video; nothing where there is none.
std::optional<std::filesystem::path> depthkit_metadata_of(const std::filesystem::path& video);
/// The video that such a description lies beside; nothing where there is none, or the file is none.
std::optional<std::filesystem::path> depthkit_video_of(const std::filesystem::path& metadata);

/// A Depthkit video, QuickTime or MP4: colour in the upper half of each picture, depth as hue in the lower.
/// `metadata` is the Unity asset that describes it, of one perspective, uncropped. `described` replaces the
/// scene made from it.
Result<std::unique_ptr<ClipReader>> open_depthkit_clip(const SourceFile& video,
                                                       const std::filesystem::path& metadata,
                                                       const std::optional<SceneDescription>& described);

}  // namespace touchable
