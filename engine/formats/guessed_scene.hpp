#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/video_file.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// What describes pictures that have no scene file: what is said and known of them, and guesses for the rest,
/// which its remarks tell.
struct GuessedScene : SceneDescription {
    std::vector<std::filesystem::path> inputs;  ///< files that were read for it, beside pictures
    // What was opened for it, for whoever opens the clip.
    std::shared_ptr<ReadPictures> pictures{};  ///< of a folder or a picture
    std::shared_ptr<VideoFile> video{};        ///< of a video: its depth
};

/// Of a folder: which pictures are depth and which are colour, by their names, kinds and lists; then as for a
/// picture. An error says what was found there.
Result<GuessedScene> guess_folder(const std::filesystem::path& folder, const SourceDescription& known);

/// Of depth as in this picture, in a folder that may have a camera's file. Where `coding` is given it stands,
/// and nothing of the picture but its size counts. The scene says nothing of files.
Result<GuessedScene> guess_scene(const std::filesystem::path& folder, const StoredImage& depth,
                                 const SourceDescription& known, const DepthCoding* coding = nullptr);

/// Of a single picture of depth. Camera: as said, by preset, by a camera's file beside it, or 60 degrees
/// wide. Unit: as said, by preset, or by the size of its values. `scene.folder` names it.
Result<GuessedScene> guess_picture(const SourceFile& file, const SourceDescription& known);

}  // namespace touchable
