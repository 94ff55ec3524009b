#pragma once

// Guesses the scene of depth pictures that have no scene file: camera, unit, coding, rate, and which files
// are depth and which are colour. What is known (SourceDescription) stands; what is not is taken from files
// beside the pictures, from their names and from their values. Each guess is a remark in the scene, with the
// settings that say another, so that a program can show what was assumed.
//
//   TRY_ASSIGN(auto guessed, guess_scene("/dev", first_picture, known));
//   for (const Remark& remark : guessed.scene.remarks) show(remark);
//
// A GuessedScene leaves open what only a whole clip tells (unstated): a reader settles it (engine/scene).
// Clips are guessed by guess_clip (open_clip.hpp); the functions here are for a folder, one picture and a
// camera's first picture.
//
// Reading may take long: every function returns an error of kind interrupted soon after the thread was asked
// to stop (engine/base/threads.hpp). Any thread may call them, several at once too. A GuessedScene
// belongs to one thread at a time, as what was opened for it does.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

class ReadPictures;
class VideoFile;
struct StoredImage;

/// What describes pictures that have no scene file: what is said and known of them, and guesses for the rest,
/// which its remarks tell.
struct GuessedScene : SceneDescription {
    std::vector<std::filesystem::path> inputs;  ///< files that were read for it, beside pictures
    // What was opened for it, so that the clip need not open it again.
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

/// A remark that doubts the unit of a clip whose median depth, in metres, no depth camera measures; nothing
/// where the unit may be right. `otherwise` and `hints` are the remark's.
std::optional<Remark> unit_doubt(double median_m, std::string otherwise, Hints hints);

/// Whether a remark guesses the camera, or doubts the unit; also one that was read from a scene file.
bool guesses_camera(const Remark& remark);
bool doubts_unit(const Remark& remark);

}  // namespace touchable
