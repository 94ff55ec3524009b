#pragma once

// Writers of the formats that other programs read, beside our own clips (engine/clip): pictures in a folder,
// one frame as pictures, as an MPEG-4 scene's text or in one MP4 file, a glTF scene, LeRobot's video of
// depth.
//
// Each create_ function checks that the clip can be stored so and returns a ClipWriter, which takes the
// frames in order; `finish` gives the files their names. Until then they lie in a hidden folder or file
// beside their place, which is removed with the writer: a clip is there as a whole, or not at all.
// `existing`: whether a file of that name may be replaced. A _files function lists every file that a writer
// may write, so that a caller can compare them with its inputs first. Pictures are PNG, which keeps every
// value.
//
// A writer is used by one thread; several writers may be used at once. Errors are one line with the name that
// the file would have had.

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A folder that opens as a clip as it is: scene.json, depth_000000.png and so on, colour_, haptic_ and
/// height_; a plane that is the same in every frame is one picture, such as haptic.png. `existing`: of an
/// earlier folder only one like it (`is_image_folder`) is replaced.
Result<std::unique_ptr<ClipWriter>> create_image_folder(const std::filesystem::path& folder,
                                                        const SceneDescription& described, Existing existing);
/// Whether a folder holds nothing but what `create_image_folder` writes; an empty one does.
bool is_image_folder(const std::filesystem::path& folder);

/// One frame: NAME.png is its depth, NAME.json the scene file that describes it, by which it opens;
/// NAME_colour.png, NAME_haptic.png and NAME_height.png where there are such planes.
Result<std::unique_ptr<ClipWriter>> create_still(const std::filesystem::path& picture,
                                                 const SceneDescription& described, Existing existing);
/// The second opens it.
std::vector<std::filesystem::path> still_files(const std::filesystem::path& picture);

/// One frame as the paper sends a static scene: NAME.bt, the text of its MPEG-4 scene, beside NAME_depth.png,
/// NAME_colour.png and so on (docs/codecs.md). What nodes cannot say the text has as a scene file's text.
Result<std::unique_ptr<ClipWriter>> create_scene_text(const std::filesystem::path& text,
                                                      const SceneDescription& described, Existing existing);
/// The first is the text, which opens it.
std::vector<std::filesystem::path> described_still_files(const std::filesystem::path& text);

/// One frame as a static MPEG-4 scene in one MP4 file (docs/codecs.md): each plane is a track with one PNG
/// picture, also of 16 bits. What nodes cannot say is in the scene as a scene file's text.
Result<std::unique_ptr<ClipWriter>> create_mp4_stills(const std::filesystem::path& path,
                                                      const SceneDescription& described, Existing existing);

/// A touchable clip as a glTF scene (docs/codecs.md): NAME.gltf; its planes in NAME.mp4 (create_mp4_clip), or
/// of a still as PNG; NAME.bin and a poster, which programs show that know no video. `is_still`: of one
/// frame. `storage` and `sound`: of a video.
Result<std::unique_ptr<ClipWriter>> create_gltf_clip(const std::filesystem::path& path,
                                                     const SceneDescription& described, bool is_still,
                                                     const ClipStorage& storage, Existing existing,
                                                     const std::optional<SoundPart>& sound = {});
std::vector<std::filesystem::path> gltf_clip_files(const std::filesystem::path& path, bool is_still);

/// A video of depth as LeRobot writes it: MP4, HEVC of 12 bits that keeps every value, depth alone. Beside it
/// a file that says what its codes are, as "features" of a data set's meta/info.json, and its camera.
/// `scene`: of LeRobotCodes.
Result<std::unique_ptr<ClipWriter>> create_lerobot_video(const std::filesystem::path& path,
                                                         const Scene& scene, Existing existing);
/// "NAME.info.json" of "NAME.mp4".
std::filesystem::path lerobot_info_file(const std::filesystem::path& video);

/// Metres that all depth of LeRobot's is nearer than.
inline constexpr double lerobot_horizon = 1e6;

/// A clip's depth as LeRobot has it.
class LeRobotCodes {
public:
    explicit LeRobotCodes(const Scene& scene);
    /// The clip as it is then: in metres, depth alone.
    const Scene& scene() const { return scene_; }
    /// Whether the clip's codes are such codes already, and stay.
    bool are_kept() const { return are_kept_; }
    /// How far the codes about 1 m are apart, metres.
    double step_at_a_metre() const;
    /// Its depth, along the optical axis in any clip. What is nearer or deeper than the planes is at
    /// them, but never code 0.
    RawFrame of(const RawFrame& frame) const;

private:
    Scene from_, scene_;
    bool are_kept_ = false;
    std::vector<std::uint16_t> table_;  // of every stored code
};

}  // namespace touchable
