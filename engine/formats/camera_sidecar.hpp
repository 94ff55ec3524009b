#pragma once

// What files beside pictures tell of the camera: its intrinsics, those of each frame, where it stood, and
// where colour's camera stands. No file is an error where it only lies there; what calls itself a camera's
// file and is not understood is named.

#include <cmath>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

inline constexpr double usual_fov = 60;  ///< degrees, where nothing tells
/// Begins a remark that guesses the field of view (guessed_in).
inline constexpr std::string_view camera_guess_mark = "the camera sees ";
/// Begins a remark that guesses what hues stand for (guessed_in).
inline constexpr std::string_view hue_guess_mark = "red is ";
/// Begins a remark that guesses which camera it is, or how its pictures were cut or turned (guessed_in).
inline constexpr std::string_view camera_choice_mark = "the camera is ";

/// Square pixels, the axis through the middle; degrees from the left edge to the right one.
Camera camera_of_fov(double degrees, int width, int height);

/// A remark on a field of view that is guessed: how wide it is taken to be, and how much too narrow or too
/// wide all shapes are if it is wrong. Their depth is right all the same.
std::string guessed_field_of_view(double degrees);

/// A camera as a file says it.
struct CameraFile {
    Intrinsics intrinsics;
    double baseline = 0;          ///< metres; of a stereo pair, otherwise 0
    double offset = 0;            ///< of its disparities, pixels
    double codes_per_metre = 0;   ///< of its depth; 0: not said
    bool has_distortion = false;  ///< by its lens, which nothing here undoes
    std::string name{};           ///< its members, its own name, its topic
    std::string frame{};          ///< the number or the picture's stem that it stands under; empty: none
    std::size_t frames = 1;       ///< of which it is the median
    bool differs = false;         ///< these are not all the same
    bool is_of_files = false;     ///< of frames that have a file each
    bool is_bare = false;         ///< four or six numbers without names
    bool operator==(const CameraFile&) const = default;
};

/// The first camera in a camera's own file; an error where it has none (read_intrinsics).
Result<CameraFile> read_camera_file(const std::filesystem::path& file);
/// The first camera in such a file's text, unchecked; nothing where it has none.
std::optional<Intrinsics> intrinsics_in_json(const std::string& text);

/// What a text says of cameras.
struct CameraText {
    std::vector<CameraFile> cameras;  ///< in the order of the text, at most 64
    double frames_per_second = 0;     ///< 0: not said
    std::size_t timed_rows = 0;       ///< of a table, by whose times that is
    double codes_per_metre = 0;       ///< of depth; 0: not said
    double metres_per_value = 0;      ///< of depth that is no codes; 0: not said
};

/// A picture whose camera is sought among those of frames.
struct FrameKey {
    std::string stem{};        ///< empty: of no one picture
    std::string number{};      ///< in the stem, which tells it from others; without zeros before it
    std::size_t pictures = 0;  ///< how many there are: fewer cameras are not those of frames
};

/// One camera for these frames, each number the median; of one or more.
CameraFile median_camera_file(std::span<const CameraFile> cameras);

/// What a camera's own file says (read_camera_file). No camera in it is no error; an error says that it
/// cannot be read, or that every principal point is far beside its picture. Of cameras that each stand under
/// a frame only that of the `wanted` one is there, if one is surely its own.
Result<CameraText> read_camera_text(const std::filesystem::path& file, const FrameKey& wanted = {});

/// Frames a second by a file of the times of as many frames (0: any number), or of the rate alone, as its
/// name tells: timestamps.txt, times.txt, fps.txt; 0: it is none.
double rate_in_file_of_times(const std::filesystem::path& file, std::size_t frames);

/// Where pictures of depth are whose camera is sought.
struct PicturesOfCamera {
    std::filesystem::path folder{};  ///< of the clip
    std::filesystem::path within{};  ///< that of depth's pictures, from there; empty: the same
    int width = 0, height = 0;
    /// Which pictures a camera's file applies to if its name does not say: all in the folder, or only those
    /// with this stem.
    bool is_whole_folder = false;
    std::string stem{};
    bool only_named = false;                      ///< of files, those that are named as a camera's
    std::vector<std::filesystem::path> frames{};  ///< depth's pictures, one a frame; empty: not known
    CameraText own{};                             ///< what the pictures' own file says, which goes first
    std::filesystem::path own_file{};             ///< that is this
    std::vector<std::string> own_not_used{};      ///< what else is in it
};

/// What files beside pictures say of their camera.
struct CameraBeside {
    std::optional<CameraFile> camera;    ///< of pictures of this size, or of any
    std::filesystem::path file{};        ///< that has it
    std::string doubt{};                 ///< how it was taken otherwise than the file says; empty: as it says
    std::vector<std::string> guesses{};  ///< remarks on what is not sure of it (camera_choice_mark)
    double frames_per_second = 0;        ///< 0: none of them says it
    std::filesystem::path rate_file{};
    double codes_per_metre = 0;  ///< of depth; 0: none of them says it
    std::filesystem::path scale_file{};
    double metres_per_value = 0;  ///< of depth that is no codes; 0: none of them says it
    std::filesystem::path unit_file{};
    std::vector<std::string> not_understood{};  ///< names of files that call themselves a camera's
    /// Names of other files there with numbers in them, of which nothing was taken.
    std::vector<std::string> not_used{};
    /// Cameras that differ from frame to frame, as FolderSource::cameras; empty: one camera serves all.
    std::string frame_cameras{};
};

/// Looks in the folder, in depth's, in sparse/0 (COLMAP), in folders of cameras beside these (cameras/,
/// poses/, whatever has intrinsic or calib in its name ...), and, where none of these has a camera, in the
/// folder above, and farther up as long as the folders' names are those of parts of a recording. Of one
/// picture its own file goes first, which has its stem or its telling number, or its own entry in a file of
/// all frames. Of several cameras that of a file which calls itself a camera's, or has a word of the folder's
/// name in its own, of depth, of pictures of this size or nearest to it, without a lens's distortion, the
/// first by its name. Where each frame has a file of its own, the median of their cameras. What is left to
/// choice is said.
CameraBeside camera_beside(const PicturesOfCamera& pictures);

/// What arrays say that lie beside depth in its own file (.npz).
CameraText cameras_in_arrays(std::span<const SmallArray> arrays);

/// The same camera for pictures of this size, where what its file says of sizes cannot be: the principal
/// point is near the middle of a picture, and tells of which. `doubt`: what was changed.
Intrinsics trusted_intrinsics(Intrinsics camera, int width, int height, std::string& doubt);

/// The cameras in these files (read_camera_file), one a frame, for pictures of this size. An error names the
/// file and the frame.
Result<std::vector<Camera>> read_frame_cameras(const PictureFiles& files, int width, int height);

/// Each of the four numbers is the median (the lower of two in the middle) of all; of one or more.
Camera median_camera(std::span<const Camera> cameras);

/// How far two cameras show the same ray apart, pixels: at most so many columns and rows over a picture.
struct PixelShift {
    double columns = 0, rows = 0;
    bool is_inside = true;  ///< the stored picture has all that the clip's camera sees
    double length() const { return std::sqrt(columns * columns + rows * rows); }
    /// Whether the nearest pixel is anywhere another one.
    bool moves() const { return columns >= 0.5 || rows >= 0.5; }
};
PixelShift shift_between(const Camera& clip, const Camera& stored, int width, int height);

/// Files that lie in a folder of pictures, with the camera of each frame.
struct GuessedCameras {
    std::string files;  ///< as `FolderSource::cameras`; a single file's name where there is only one
    Camera median;      ///< of those that go with pictures of depth
};

/// Such files as ARKitScenes has them (.pincam), in the folder or one of its folders: of several kinds those
/// of pictures of this size, otherwise those of which there are most. Nothing where there are none; an error
/// names the file that cannot be read.
Result<std::optional<GuessedCameras>> guess_cameras(const std::filesystem::path& folder,
                                                    const std::string& depth_pattern, int width, int height);

/// Where the camera stood, as a file beside pictures says it.
struct FoundPoses {
    CameraPath path;  ///< empty: the file is not understood, as `remark` says
    std::filesystem::path file{};
    std::string remark{};
};

/// In a folder of pictures: poses.txt or groundtruth.txt (TUM RGB-D), trajectory.log or another .log with
/// "traj" in its name (Redwood, Open3D), or metadata.json (Record3D); the first of them that is there and has
/// poses. `rate`: of the frames. Those of a list with times go with the frames that are nearest, at most 20
/// ms away, or, where no times fit and there are as many, one by one. Nothing where there is no such file.
std::optional<FoundPoses> poses_beside(const std::filesystem::path& folder, const PictureFiles& depth,
                                       const FrameRate& rate, double metres_per_unit);

/// A file beside pictures that says that colour does not lie on depth's pixels: a matrix that takes points
/// from depth's camera to colour's or back (depth_M_color.txt, extrinsic_color.txt), and is more than the
/// unit matrix; nothing where there is none.
std::optional<std::filesystem::path> colour_movement_in(const std::filesystem::path& folder);

/// Colour's camera as ViSP stores it: depth_M_color.txt (`movement`; to depth's camera, metres), and beside
/// depth's NAME_depth.xml colour's NAME.xml, of pictures of this size. Nothing where it is not so.
struct VispColourCamera {
    ColourCamera camera;
    std::filesystem::path file;
};
std::optional<VispColourCamera> visp_colour_camera(const std::filesystem::path& movement,
                                                   const std::filesystem::path& camera_of_depth, int width,
                                                   int height);

/// A camera of colour that sees depth's pixels elsewhere than the scene's camera does; nothing where there is
/// none. A file that does not say of how large pictures it is, is of `width` x `height` pixels.
std::optional<std::filesystem::path> camera_of_colour_in(const std::filesystem::path& folder,
                                                         const Scene& scene, int width, int height);

}  // namespace touchable
