#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/clip/matroska_writer.hpp"

namespace touchable {

/// A touchable clip as a glTF scene (docs/mpeg4.md): NAME.gltf; its planes in NAME.mp4 (create_mp4_clip), or
/// of a still as PNG; NAME.bin and a poster, which show what knows no video. Files appear together.
/// `is_still`: of one frame. `storage` and `sound`: of a video.
Result<std::unique_ptr<ClipWriter>> create_gltf_clip(const std::filesystem::path& path,
                                                     const SceneDescription& described, bool is_still,
                                                     const ClipStorage& storage, Existing existing,
                                                     const std::optional<SoundPart>& sound = {});

/// Every file that it may write.
std::vector<std::filesystem::path> gltf_clip_files(const std::filesystem::path& path, bool is_still);

}  // namespace touchable
