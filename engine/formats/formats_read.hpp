#pragma once

// The readers of formats, for open_clip.cpp, which has the stages by which a file becomes a clip, and their
// table. A format has a probe (`is_`), a reader (`open_`), and, where its files do not say what their depth
// is, a guess (`guess_`) from what is `known` of them. Each is a function of what the stages before it found
// (Candidate); none calls one before it. A clip that is made of others' files, a scene's text or glTF, opens
// them by the same readers of pictures and videos.

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

/// A clip at its beginning, or why it cannot be read.
using Opened = Result<std::unique_ptr<ClipReader>>;

/// What describes a clip: a scene file; or what is said and known of its pictures, and guesses for the rest,
/// which its remarks tell.
struct GuessedScene : SceneDescription {
    std::vector<std::filesystem::path> inputs{};  ///< files that were read for it, beside pictures
    std::vector<std::string> notes{};             ///< before what the reader has to say
    // What was opened for it, so that the clip need not open it again.
    std::shared_ptr<ReadPictures> pictures{};  ///< of a folder or a picture
    std::shared_ptr<VideoFile> video{};        ///< of a video: its depth; of a folder: its colour
    std::shared_ptr<FrameSource> recording{};  ///< of ROS
};

/// What the caller of open_clip says.
struct OpenSettings {
    SourceDescription known{};
    Colour colour = Colour::wanted;
    DepthAlignment alignment = DepthAlignment::automatic;

    /// Whether `known` describes pictures. With a least confidence, a channel or a data set alone the rest
    /// comes from a scene file, or from guesses.
    bool is_known() const {
        SourceDescription said = known;
        said.least_confidence.reset();
        said.channel.clear();
        said.dataset.clear();
        return !(said == SourceDescription());
    }
};

/// What Matroska and WebM begin with.
inline constexpr std::string_view matroska_magic = "\x1a\x45\xdf\xa3";

/// What may be a clip, as far as it is known.
struct Candidate {
    SourceFile source;  ///< a file; with `folder`, the video in it that the scene names
    std::optional<std::filesystem::path> folder{};  ///< of pictures or videos, in place of a file
    std::optional<GuessedScene> scene{};            ///< in place of what the file says of itself
    OpenSettings wanted{};

    static constexpr std::size_t telling_bytes = 16;
    std::string begin = folder ? std::string() : first_bytes(source, telling_bytes);
    /// The folder that names in the scene are of.
    std::filesystem::path home() const { return folder ? *folder : source.path().parent_path(); }
    std::optional<SceneDescription> described() const {
        return scene ? std::optional<SceneDescription>(*scene) : std::nullopt;
    }
};

// guessed_scene.cpp

/// Of a folder: which pictures are depth and which are colour, by their names, kinds and lists; then as for a
/// picture. An error says what was found there.
Result<GuessedScene> guess_folder(const std::filesystem::path& folder, const SourceDescription& known);

/// Of a file's depth as in this picture, with a camera's file beside it perhaps. Where `coding` is given it
/// stands, and nothing of the picture but its size counts. The scene has the file's name, and names no files.
Result<GuessedScene> guess_scene(const std::filesystem::path& file, const StoredImage& depth,
                                 const SourceDescription& known, const DepthCoding* coding = nullptr);

/// Of a single picture of depth. Camera: as said, by preset, by a camera's file beside it, or 60 degrees
/// wide. Unit: as said, by preset, or by the size of its values. `scene.folder` names it.
Result<GuessedScene> guess_picture(const SourceFile& file, const SourceDescription& known);

// image_folder.cpp

/// Pictures in `folder`, found by the patterns of the scene's FolderSource.
Opened open_image_folder(const std::filesystem::path& folder, const GuessedScene& described,
                         Colour colour = Colour::wanted,
                         DepthAlignment alignment = DepthAlignment::automatic);

// video_clip.cpp

/// Of a video without a scene file, by its first picture: LeRobot's depth; Record3D's export (hue on the
/// left, its camera at the file's end); a half that is grey beside one that is not; grey everywhere; one map
/// of hues everywhere. Camera and unit as for a picture. An error says what was seen, and what would open it.
Result<GuessedScene> guess_video(const SourceFile& file, const SourceDescription& known);
/// The video, or the two, in `folder` that the scene's VideoSource names.
Opened open_videos(const std::filesystem::path& folder, const GuessedScene& described,
                   Colour colour = Colour::wanted, DepthAlignment alignment = DepthAlignment::automatic);

// lerobot.cpp

/// LeRobot's video of depth: grey of 12 bits as HEVC, metres.
struct LeRobotDepth {
    DepthCoding coding;
    std::filesystem::path info{};    ///< the file that says so; empty: none does, and it is LeRobot's usual
    std::filesystem::path colour{};  ///< the video of colour beside it, as seen from its folder; empty: none
    std::optional<Intrinsics> camera{};  ///< that `info` may name; LeRobot's own do not
};
/// As the features say in NAME.info.json beside NAME.mp4, or in meta/info.json of the data set that it lies
/// in. Nothing where there is neither and its pixels (`codec` and `pixel_format`, as FFmpeg calls them) are
/// not as LeRobot has them. Refused: what is said to be such depth and was encoded anew otherwise, and
/// numbers that are no such coding.
Result<std::optional<LeRobotDepth>> find_lerobot_depth(const SourceFile& video, const std::string& codec,
                                                       const std::string& pixel_format);
/// The videos of depth in a data set's folder, by name; none where it is no data set with depth.
Result<std::vector<std::filesystem::path>> lerobot_depth_videos(const std::filesystem::path& folder);

// scene_text.cpp and mp4_stills.cpp (docs/codecs.md)

/// Whether a file is the text of an MPEG-4 scene, as its first word tells.
bool is_scene_text(const Candidate& file);
/// A touchable clip whose MPEG-4 scene is text, beside the pictures or videos that it names. They lie in its
/// folder or below; nothing is fetched from elsewhere.
Opened open_scene_text(const Candidate& file);

/// Whether an MP4 file's MPEG-4 scene is a static one in the same file: its depth is an ImageTexture, whose
/// track is a PNG or JPEG picture.
bool is_mp4_stills(const SourceFile& file);
/// Such a scene as a clip of one frame.
Opened open_mp4_stills(const Candidate& file);

// gltf_reader.cpp (docs/codecs.md)

/// Whether a file is glTF, by its name (.gltf, .glb) or its first bytes.
bool is_gltf(const Candidate& file);
/// A touchable clip that a glTF scene describes: its planes are textures, tracks of one MP4 file or pictures,
/// in the scene's folder or below; nothing is fetched. What they mean stands in "extras" of its mesh. Without
/// that, near and far plane and the camera are assumed, and said. Refused where no texture is depth.
Opened open_gltf_clip(const Candidate& file);

// azure_kinect.cpp

/// Whether a file is Matroska as the Azure Kinect's recorder writes it: tracks of the names DEPTH and perhaps
/// COLOR, tags K4A_*.
bool is_k4a_recording(const Candidate& file);
/// Its scene: depth in millimetres, cameras and lenses as its calibration.json has them.
Result<GuessedScene> guess_k4a(const SourceFile& file, const SourceDescription& known);

/// The cameras of an Azure Kinect, or of an Orbbec Femto that records as one.
struct K4aCameras {
    Camera depth;  ///< of the picture as it is stored, which its lens bends
    LensDistortion depth_lens;
    std::optional<ColourCamera> colour;  ///< scene units: metres
};
/// Pixels of a picture.
struct PictureSize {
    int width = 0, height = 0;
};
/// What a recording's calibration.json says of pictures of these sizes, which the camera's modes have.
Result<K4aCameras> parse_azure_kinect_calibration(std::string_view text, PictureSize depth,
                                                  const std::optional<PictureSize>& colour,
                                                  const std::string& where);

// depthkit.cpp

/// The name of a Depthkit video's description: "Test.Metadata.asset" for "Test.mov".
std::filesystem::path depthkit_metadata_name(const std::filesystem::path& video);
/// The description beside a video; nothing where there is none.
std::optional<std::filesystem::path> depthkit_metadata_of(const std::filesystem::path& video);
/// The video that such a description lies beside; nothing where there is none, or the file is none.
std::optional<std::filesystem::path> depthkit_video_of(const std::filesystem::path& metadata);
/// The scene by such a description, a Unity asset: all but name and rate, lengths in metres. Refused where a
/// field is missing or the pictures are laid out otherwise than one perspective, uncropped, colour above
/// depth.
Result<SceneDescription> read_depthkit_metadata(const std::filesystem::path& file);
/// A Depthkit video with its description beside it, QuickTime or MP4: colour in the upper half of each
/// picture, depth as hue in the lower.
Opened open_depthkit_clip(const Candidate& video);

// bag_clip.cpp; bag_file.hpp has the probe

/// What a recording of ROS says of itself (camera, unit, times), and guesses for the rest.
Result<GuessedScene> guess_bag(const SourceFile& file, const SourceDescription& known);
/// Its depth and colour as a clip of its scene.
Opened open_bag_clip(const Candidate& file);
/// The file of a recording in a folder as ROS 2 makes it, with metadata.yaml and a .db3 or an .mcap; nothing
/// where it is no such folder. Refused: one with several files, and one whose file is packed as a whole.
Result<std::optional<std::filesystem::path>> ros2_recording_in(const std::filesystem::path& folder);

}  // namespace touchable
