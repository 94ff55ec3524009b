// SPDX-License-Identifier: Apache-2.0
#pragma once

// The readers of formats. open_clip.cpp has the table of formats and the stages that make a file a clip. A
// format has a probe (`is_`), a reader (`open_`), and, if its files do not say what their depth is, a guess
// (`guess_`) from what is `known` of them. Each takes what the earlier stages found (Candidate) and calls no
// earlier stage. Formats that name other files (a scene's text, glTF) open them with the same readers of
// pictures and videos.

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

class FrameSource;
class VideoFile;

/// A clip at its beginning, or an error.
using Opened = Result<std::unique_ptr<ClipReader>>;

/// A clip's description: a scene file's; or what a person stated and files tell, with guesses for the rest,
/// which its remarks name.
struct GuessedScene : SceneDescription {
    std::vector<std::filesystem::path> inputs{};  ///< files read for it, other than pictures
    std::vector<ClipNote> notes{};                ///< come before the reader's own notes
    // Files opened for the guess, so that the clip need not open them again.
    std::shared_ptr<ReadPictures> pictures{};  ///< of a folder or a single picture
    std::shared_ptr<VideoFile> video{};        ///< a video's depth, or a folder's colour
    std::shared_ptr<FrameSource> recording{};  ///< a recording of ROS
};

/// open_clip's arguments.
struct OpenSettings {
    SourceDescription known{};
    Colour colour = Colour::wanted;
    DepthAlignment alignment = DepthAlignment::automatic;

    /// Whether `known` describes pictures (SourceSetting::describes).
    bool is_known() const {
        return known.intrinsics ||
               std::ranges::any_of(source_settings(), [this](const SourceSetting& setting) {
                   return setting.describes && setting.get(known);
               });
    }
};

/// First bytes of Matroska and WebM files.
inline constexpr std::string_view matroska_magic = "\x1a\x45\xdf\xa3";

/// A file or folder that may be a clip, with what is known of it so far.
struct Candidate {
    SourceFile source;  ///< a file; with `folder`, the video in it that the scene names
    std::optional<std::filesystem::path> folder{};  ///< of pictures or videos; nothing: the clip is a file
    std::optional<GuessedScene> scene{};            ///< replaces what the file says of itself
    OpenSettings wanted{};

    static constexpr std::size_t telling_bytes = 16;
    std::string begin = folder ? std::string() : first_bytes(source, telling_bytes);
    /// The folder that file names in the scene are relative to.
    std::filesystem::path home() const { return folder ? *folder : source.path().parent_path(); }
    std::optional<SceneDescription> described() const {
        return scene ? std::optional<SceneDescription>(*scene) : std::nullopt;
    }
};

// guessed_scene.cpp

/// Chooses a folder's depth and colour pictures by their names, kinds and lists; the rest as for a picture.
/// An error says what the folder has.
Result<GuessedScene> guess_folder(const std::filesystem::path& folder, const SourceDescription& known);

/// Guesses the scene of a file with depth as in this picture; a camera's file beside it counts. `coding`, if
/// given, is kept, and only the picture's size counts. `usual_unit`: metres of a stored 1 as the format
/// defines it, which is taken unless values contradict it. The scene has the file's name and names no files.
Result<GuessedScene> guess_scene(const std::filesystem::path& file, const StoredImage& depth,
                                 const SourceDescription& known, const DepthCoding* coding = nullptr,
                                 double usual_unit = 0);

/// Guesses the scene of a single depth picture. Camera: as stated, from a camera's file beside it, by preset,
/// or 60 degrees wide. Unit: as stated, by preset, from files or names, or by the size of its values.
/// `scene.folder` names the picture.
Result<GuessedScene> guess_picture(const SourceFile& file, const SourceDescription& known);

// image_folder.cpp

/// Opens the pictures in `folder` that match the patterns of the scene's FolderSource.
Opened open_image_folder(const std::filesystem::path& folder, const GuessedScene& described, Colour colour,
                         DepthAlignment alignment);

// packed_clip.cpp

/// Whether a file is the clip.json of a packed clip, by its first bytes.
bool is_packed_clip(const SourceFile& file);
Opened open_packed_clip(const Candidate& candidate);

// video_clip.cpp

/// Guesses the scene of a video by its first picture: LeRobot's depth; Record3D's export (hue on the left,
/// its camera at the file's end); one half grey and the other not; grey everywhere; one map of hues
/// everywhere. Camera and unit as for a picture. An error says what was seen and what would open it.
Result<GuessedScene> guess_video(const SourceFile& file, const SourceDescription& known);
/// Opens the one or two videos in `folder` that the scene's VideoSource names.
Opened open_videos(const std::filesystem::path& folder, const GuessedScene& described, Colour colour,
                   DepthAlignment alignment);

/// The pictures of a video whose halves are depth and colour, with nothing between them. `notes` gets a
/// remark if the depth is to be hue and is grey.
std::shared_ptr<FrameSource> pictures_of_halves(const VideoSource& source, std::shared_ptr<VideoFile> video,
                                                std::vector<ClipNote>& notes);

// lerobot.cpp

/// LeRobot's depth video: 12-bit grey in HEVC, metres.
struct LeRobotDepth {
    DepthCoding coding;
    std::filesystem::path info{};        ///< the file that states the coding; empty: LeRobot's defaults apply
    std::filesystem::path colour{};      ///< the colour video's path from depth's folder; empty: none
    std::optional<Intrinsics> camera{};  ///< stated in `info`; LeRobot's own files have none
};
/// Reads the features in NAME.info.json beside NAME.mp4, or in meta/info.json of the data set around it.
/// Returns nothing if neither file describes the video and its `codec` and `pixel_format` (FFmpeg's names)
/// are not LeRobot's. An error if a file calls the video LeRobot's depth but it was re-encoded in another
/// format, or if the numbers are no valid coding.
Result<std::optional<LeRobotDepth>> find_lerobot_depth(const SourceFile& video, const std::string& codec,
                                                       const std::string& pixel_format);
/// The depth videos in a data set's folder, by name; none if the folder is no data set with depth.
Result<std::vector<std::filesystem::path>> lerobot_depth_videos(const std::filesystem::path& folder);

// scene_text.cpp and mp4_stills.cpp (docs/codecs.md)

/// Whether a file is the text of an MPEG-4 scene, by its first word.
bool is_scene_text(const Candidate& file);
/// Opens a touchable clip whose MPEG-4 scene is text. The pictures or videos that the text names must lie in
/// its folder or below; nothing is fetched from elsewhere.
Opened open_scene_text(const Candidate& file);

/// Whether an MP4 file holds a static MPEG-4 scene: its depth is an ImageTexture whose track is a PNG or JPEG
/// picture.
bool is_mp4_stills(const SourceFile& file);
/// Opens a static MPEG-4 scene as a clip of one frame.
Opened open_mp4_stills(const Candidate& file);

// gltf_reader.cpp (docs/codecs.md)

/// Whether a file is glTF, by its name (.gltf, .glb) or its first bytes.
bool is_gltf(const Candidate& file);
/// Opens the clip that a glTF scene describes: its planes are textures, tracks of one MP4 file or pictures,
/// in the scene's folder or below; nothing is fetched. The mesh's "extras" say what they mean; without these,
/// near and far plane and the camera are assumed, with remarks. An error if no texture is depth.
Opened open_gltf_clip(const Candidate& file);

// azure_kinect.cpp

/// Whether a file is Matroska as the Azure Kinect's recorder writes it: a track DEPTH and perhaps one COLOR,
/// tags K4A_* or an attached calibration.json.
bool is_k4a_recording(const Candidate& file);
/// The recording's scene: depth in millimetres, cameras and lenses from its calibration.json.
Result<GuessedScene> guess_k4a(const SourceFile& file, const SourceDescription& known);

/// The cameras of an Azure Kinect, or of an Orbbec Femto that records as one.
struct K4aCameras {
    Camera depth;  ///< of the stored picture, which has the lens's distortion
    LensDistortion depth_lens;
    std::optional<ColourCamera> colour;  ///< lengths in metres
};
/// A picture's size, pixels.
struct PictureSize {
    int width = 0, height = 0;
};
/// Reads a recording's calibration.json for pictures of these sizes, each that of a camera mode.
Result<K4aCameras> parse_azure_kinect_calibration(std::string_view text, PictureSize depth,
                                                  const std::optional<PictureSize>& colour,
                                                  const std::string& where);

// depthkit.cpp

/// The name of a Depthkit video's description: "Test.Metadata.asset" for "Test.mov".
std::filesystem::path depthkit_metadata_name(const std::filesystem::path& video);
/// The description beside a video; nothing if there is none.
std::optional<std::filesystem::path> depthkit_metadata_of(const std::filesystem::path& video);
/// The video beside a description; nothing if there is none, or `metadata` is no such file.
std::optional<std::filesystem::path> depthkit_video_of(const std::filesystem::path& metadata);
/// Reads the scene from a description, a Unity asset: all but name and rate, lengths in metres. An error if a
/// field is missing, or if the layout is not one perspective, uncropped, with colour above depth.
Result<SceneDescription> read_depthkit_metadata(const std::filesystem::path& file);
/// Opens a Depthkit video (QuickTime or MP4) with its description beside it: colour in the upper half of each
/// picture, depth as hue in the lower.
Opened open_depthkit_clip(const Candidate& video);

// bag_clip.cpp; bag_file.hpp has the probe

/// Describes a recording of ROS by what it says of camera, unit and times, and guesses the rest.
Result<GuessedScene> guess_bag(const SourceFile& file, const SourceDescription& known);
/// Opens the recording's depth and colour as a clip.
Opened open_bag_clip(const Candidate& file);
/// The .db3 or .mcap file in a recording's folder as ROS 2 makes it, with metadata.yaml; nothing for other
/// folders. An error if the recording has several files, or its file is compressed as a whole.
Result<std::optional<std::filesystem::path>> ros2_recording_in(const std::filesystem::path& folder);

// realsense_raw.cpp
// A snapshot of the RealSense Viewer: NAME_Depth.raw has the codes of a depth picture, without a header, and
// NAME_Depth_metadata.csv beside it states its size and camera. (NAME_Depth.png is that picture in false
// colours, from which depth cannot be restored.)

/// The metadata beside a file NAME.raw; nothing if there is none.
std::optional<std::filesystem::path> realsense_metadata_of(const std::filesystem::path& raw);
/// The depth snapshot in a folder that has exactly one and no other depth pictures; otherwise nothing.
std::optional<std::filesystem::path> realsense_snapshot_in(const std::filesystem::path& folder);

/// The camera and picture size in the metadata. An error if either is missing, or if the format is not 16-bit
/// depth (Z16). Messages begin with `where`.
Result<Intrinsics> parse_realsense_metadata(std::string_view text, const std::string& where);
Result<Intrinsics> read_realsense_metadata(const std::filesystem::path& metadata);

/// Reads a snapshot's depth picture. An error if the file's length does not match the size in the metadata.
Result<StoredImage> read_realsense_raw(const SourceFile& raw);

// foreign_files.cpp
// Recordings, archives and containers of other programs that are not opened, but recognised: by their first
// bytes, or by their name if the bytes say less. One sentence for each says what the file is and what to do
// with it.

/// What a file is and what to do, as the end of a sentence that begins with its name: "is a Git LFS pointer
/// ...: git lfs pull". Nothing for a kind of file that is not known here.
std::optional<std::string> foreign_file(const SourceFile& file);

/// The same for files that one of our readers would mistake for its own: SVO2 is MCAP inside, a Git LFS
/// pointer has the name of the file that it stands for, and .npz are ZIP files. `begin`: the file's first 16
/// bytes, or all; unless these fit such a file, nothing more is read.
std::optional<std::string> misleading_file(const SourceFile& file, std::string_view begin);

/// The same for a folder that other programs treat as one file (.zarr).
std::optional<std::string> foreign_folder(const std::filesystem::path& folder);

/// A projection that no pinhole camera has.
struct Projection {
    std::string name{};      ///< "a cube map"
    std::string evidence{};  ///< "as its name says"; empty: depth's values alone, which may deceive
    std::string way{};       ///< how Python makes a view of it that opens
    Hints hints{};           ///< of that view
};
/// The projection of a picture of depth, with colour beside it (empty: none): an equirectangular panorama by
/// its XMP (ReadPictures::has_panorama), or if it is twice as wide as high by its name or its values; a cube
/// map, a fisheye picture or a cylinder's by its shape and name, the latter unless a file has its camera. A
/// name is its own or one of the two folders' that it is in. Nothing for a pinhole camera's, as far as is
/// known.
std::optional<Projection> projection_of(const StoredImage& picture, const std::filesystem::path& depth,
                                        const std::filesystem::path& colour, bool has_xmp, bool has_camera);

/// The first foreign file by name in a folder or up to three folders below it: "NAME is ...". Looks at 10000
/// entries and opens 64 files at most.
std::optional<std::string> foreign_file_below(const std::filesystem::path& folder);

}  // namespace touchable
