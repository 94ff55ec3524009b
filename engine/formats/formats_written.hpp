// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writers of the formats that other programs read, besides our own clips (engine/clip): pictures in a folder,
// one frame as pictures, as an MPEG-4 scene's text or in one MP4 file, a glTF scene, depth as floats, LeRobot's
// depth video.
//
// Each create_ function checks that the format can store the clip and returns a ClipWriter, which takes the
// frames in order; `finish` gives the files their names. Until then the files lie in a hidden folder or file
// beside their place, which is removed with the writer: a clip exists as a whole or not at all. `existing`:
// whether a file of that name may be replaced. A _files function lists every file that a writer may write, so
// that a caller can first compare them with its inputs. Pictures are PNG, which keeps every value.
//
// Threads: one uses a writer; several writers may be used at once. Errors are one line with the name that the
// file would have had.

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A folder that opens as a clip as it is: scene.json, depth_000000.png and so on, colour_, haptic_ and
/// height_; a plane that is the same in every frame is one picture, such as haptic.png. `existing`: an
/// earlier folder is replaced only if it holds nothing else (`is_image_folder`).
Result<std::unique_ptr<ClipWriter>> create_image_folder(const std::filesystem::path& folder,
                                                        const SceneDescription& described, Existing existing);
/// Whether a folder holds nothing but what `create_image_folder` writes; also true for an empty folder.
bool is_image_folder(const std::filesystem::path& folder);

/// One frame: NAME.png is its depth, NAME.json the scene file that describes it and opens as the clip;
/// NAME_colour.png, NAME_haptic.png and NAME_height.png if the frame has these planes.
Result<std::unique_ptr<ClipWriter>> create_still(const std::filesystem::path& picture,
                                                 const SceneDescription& described, Existing existing);
/// The files of create_still; the second is the scene file.
std::vector<std::filesystem::path> still_files(const std::filesystem::path& picture);

/// Depth alone, as floats of metres, NaN where there is no surface: NAME.npy, an array (frames, height,
/// width), or NAME.exr, one frame. NAME.json beside it is the scene file, and opens as the clip.
Result<std::unique_ptr<ClipWriter>> create_float_depth(const std::filesystem::path& path,
                                                       const SceneDescription& described, Existing existing);

/// One frame as the paper sends a static scene: NAME.bt, the text of its MPEG-4 scene, beside NAME_depth.png,
/// NAME_colour.png and so on (docs/codecs.md). The text has a scene file's JSON for what nodes cannot
/// express.
Result<std::unique_ptr<ClipWriter>> create_scene_text(const std::filesystem::path& text,
                                                      const SceneDescription& described, Existing existing);
/// The files of create_scene_text; the first is the text, which opens as the clip.
std::vector<std::filesystem::path> described_still_files(const std::filesystem::path& text);

/// One frame as a static MPEG-4 scene in one MP4 file (docs/codecs.md): each plane is a track with one PNG
/// picture of up to 16 bits. What the nodes cannot express is in the scene as a scene file's JSON.
Result<std::unique_ptr<ClipWriter>> create_mp4_stills(const std::filesystem::path& path,
                                                      const SceneDescription& described, Existing existing);

/// A touchable clip as a glTF scene (docs/codecs.md): NAME.gltf; its planes in NAME.mp4 (create_clip), or
/// as PNG if `is_still` (one frame); a mesh (NAME.bin) and a poster, which programs without video support
/// show. `storage` and `sound` apply to the video.
Result<std::unique_ptr<ClipWriter>> create_gltf_clip(const std::filesystem::path& path,
                                                     const SceneDescription& described, bool is_still,
                                                     const ClipStorage& storage, Existing existing,
                                                     const std::optional<SoundPart>& sound = {});
std::vector<std::filesystem::path> gltf_clip_files(const std::filesystem::path& path, bool is_still);

/// A clip for pages in browsers (docs/web.md): clip.json, with its scene also as numbers, and for each plane
/// one file of packets, the planes that are felt to the bit, colour as JPEG. `described` leaves nothing open.
/// `page`: files that are copied beside it. An earlier clip is replaced only if `existing` says so, at once,
/// as clip.json names its planes by hashes; then its files and its page's are removed. Other files stay.
Result<std::unique_ptr<ClipWriter>> create_packed_clip(const std::filesystem::path& folder,
                                                       const SceneDescription& described,
                                                       const std::vector<std::filesystem::path>& page,
                                                       Existing existing);
/// The file that opens it.
inline constexpr const char* packed_clip_name = "clip.json";

/// Packs frames for a page, one after the other, by PlaneRole: empty where a plane is that of the frame
/// before, or there is none.
class FramePacker {
public:
    /// `level` of deflate: 1, the quickest, to 9, the smallest.
    explicit FramePacker(int level = 9) : level_(level) {}
    /// The next frame is packed whole.
    void forget() { before_ = {}; }
    Result<std::array<std::string, all_roles.size()>> pack(const RawFrame& frame);

private:
    const int level_;
    std::array<std::optional<RankEncoder>, all_roles.size()> encoders_;
    RawFrame before_;
};
/// clip.json of a live source, whose frames a page gets from `live`, an address beside it (docs/web.md).
std::string packed_live_json(const SceneDescription& described, const RawFrame& first,
                             const std::string& live);

/// A depth video as LeRobot writes it: MP4 with lossless 12-bit HEVC, depth alone. A file beside it states
/// the coding, as "features" of a data set's meta/info.json do, and the camera. `scene`: LeRobotCodes::scene.
Result<std::unique_ptr<ClipWriter>> create_lerobot_video(const std::filesystem::path& path,
                                                         const Scene& scene, Existing existing);
/// Returns "NAME.info.json" for "NAME.mp4".
std::filesystem::path lerobot_info_file(const std::filesystem::path& video);

/// metres; LeRobot's depth is nearer than this
inline constexpr double lerobot_horizon = 1e6;

/// Converts a clip's depth to LeRobot's codes.
class LeRobotCodes {
public:
    explicit LeRobotCodes(const Scene& scene);
    /// The converted clip's scene: LeRobot's depth coding, no heights.
    const Scene& scene() const { return scene_; }
    /// Whether the clip has LeRobot's codes already, which are kept.
    bool are_kept() const { return are_kept_; }
    /// Distance between the two codes next to 1 m, metres.
    double step_at_a_metre() const;
    /// The frame's depth plane alone, along the optical axis even if the clip's is along the rays. Valid
    /// depth beyond the near or far plane is clamped to it and never gets code 0.
    RawFrame of(const RawFrame& frame) const;

private:
    Scene from_, scene_;
    bool are_kept_ = false;
    std::vector<std::uint16_t> table_;  // code for every stored code
};

}  // namespace touchable
