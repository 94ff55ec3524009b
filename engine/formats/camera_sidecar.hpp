// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads from files beside pictures: the camera's intrinsics, those of each frame, its poses, and where
// colour's camera stands. A file that merely lies there is no error; one that is named as a camera's and is
// not understood is reported.

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

inline constexpr double usual_fov = 60;  ///< degrees; used if nothing states it
inline constexpr double assumed_near = 0.5, assumed_far = 1.5;  ///< metres; of depth without a scale

/// The words of a remark on a guessed field of view (RemarkKind::camera): its width, and how much too narrow
/// all shapes are if the camera sees 10 degrees more. Their depth is right in any case.
std::string guessed_field_of_view(double degrees);

/// A camera as a file states it.
struct CameraFile {
    Intrinsics intrinsics;
    double baseline = 0;          ///< metres; of a stereo pair, otherwise 0
    double offset = 0;            ///< pixels; of its disparities
    double codes_per_metre = 0;   ///< of depth; 0: not stated
    bool scale_differs = false;   ///< other frames of the file have other scales
    bool has_distortion = false;  ///< of its lens, which is not undone
    std::string name{};           ///< from its members, its own name, its topic
    std::string frame{};          ///< its frame's number or picture stem; empty: none
    std::size_t frames = 1;       ///< number of frames whose median it is
    bool differs = false;         ///< the frames' cameras differ
    bool is_of_files = false;     ///< each of the frames has a file
    bool is_bare = false;         ///< four or six numbers without names
    bool operator==(const CameraFile&) const = default;
};

/// Reads the first camera in a camera's own file; an error if it has none (read_intrinsics).
Result<CameraFile> read_camera_file(const std::filesystem::path& file);
/// The first camera in such a file's text, unchecked; nothing if it has none.
std::optional<Intrinsics> intrinsics_in_json(const std::string& text);

/// Cameras, rate and scales in a text.
struct CameraText {
    std::vector<CameraFile> cameras;  ///< in the order of the text, at most 64
    double frames_per_second = 0;     ///< 0: not said
    std::size_t timed_rows = 0;       ///< rows of the table whose times gave that rate
    double codes_per_metre = 0;       ///< of depth; 0: not said
    double metres_per_value = 0;      ///< of depth that is no codes; 0: not said
    double near = 0, far = 0;         ///< a renderer's planes, metres; 0: not said
};

/// The picture whose camera is sought among frames' cameras.
struct FrameKey {
    std::string stem{};        ///< empty: no single picture
    std::string number{};      ///< in the stem, different in each stem; without leading zeros
    std::size_t pictures = 0;  ///< number of pictures; fewer cameras are not one a frame
};

/// One camera for one or more frames; each of its numbers is the median.
CameraFile median_camera_file(std::span<const CameraFile> cameras);

/// Reads a camera's own file (read_camera_file). A file without a camera is no error; an error if it cannot
/// be read, or every principal point is far outside its picture. Of cameras listed by frame only that of
/// `wanted` is returned, if one is surely its own.
Result<CameraText> read_camera_text(const std::filesystem::path& file, const FrameKey& wanted = {});

/// Frames a second from a file named for the times of `frames` frames (0: any number), such as timestamps.txt
/// or times.txt, or for the rate alone (fps.txt); 0: it is no such file.
double rate_in_file_of_times(const std::filesystem::path& file, std::size_t frames);

/// The depth pictures whose camera is sought.
struct PicturesOfCamera {
    std::filesystem::path folder{};  ///< of the clip
    std::filesystem::path within{};  ///< depth's folder, relative to that; empty: the same
    int width = 0, height = 0;
    /// Which pictures a camera's file applies to if its name does not say: all in the folder, or only those
    /// with this stem.
    bool is_whole_folder = false;
    std::string stem{};
    std::vector<std::filesystem::path> frames{};  ///< depth's pictures, one a frame; empty: not known
    CameraText own{};                             ///< from the pictures' own file; goes first
    std::filesystem::path own_file{};             ///< that file
    std::vector<std::string> own_not_used{};      ///< what else it has
};

/// A number, and the file that states it; 0: none does.
struct StatedNumber {
    double value = 0;
    std::filesystem::path file{};
    /// Takes the number of another file, unless one before it states one.
    void add(double stated, const std::filesystem::path& in) {
        if (value <= 0 && stated > 0) *this = {stated, in};
    }
};

/// The result of camera_beside.
struct CameraBeside {
    std::optional<CameraFile> camera;    ///< for pictures of this size, or of any
    std::filesystem::path file{};        ///< the camera's file
    std::string doubt{};                 ///< how it differs from what the file says; empty: it does not
    std::vector<std::string> guesses{};  ///< which camera it is, or how its pictures were cut or turned
    StatedNumber frames_per_second{};
    StatedNumber codes_per_metre{};             ///< of depth
    StatedNumber metres_per_value{};            ///< of depth that is no codes
    StatedNumber near{}, far{};                 ///< a renderer's planes, metres
    std::vector<std::string> not_understood{};  ///< files named as a camera's
    /// Names of other files with numbers in them, from which nothing was taken.
    std::vector<std::string> not_used{};
    /// Cameras that differ from frame to frame, as FolderSource::cameras; empty: one camera serves all.
    std::string frame_cameras{};
};

/// Searches the folder, depth's folder, sparse/0 (COLMAP) and folders of cameras beside these (cameras/,
/// poses/, names with intrinsic or calib ...); if none has a camera, also the folder above, and farther up
/// while the folders' names are those of a recording's parts. For a single picture its own file goes first,
/// with its stem or telling number, or its entry in a file of all frames. Of several cameras, what counts in
/// this order: of depth, of this picture size, a word of the folder's name in its own, a file named as a
/// camera's, the nearest size, not of colour, no lens distortion, first by name. If each frame has a file,
/// the median of their cameras. Remarks name arbitrary choices.
CameraBeside camera_beside(const PicturesOfCamera& pictures);

/// Cameras, rate and scale in arrays beside depth in its own file (.npz) of so many frames; 0: not known.
CameraText cameras_in_arrays(std::span<const SmallArray> arrays, std::int64_t frames = 0);

/// Brings numbers that are shares of a picture's sides to pixels, each by itself; a principal point in the
/// corner is dropped. `doubt` gets what was changed.
Intrinsics in_pixels(Intrinsics camera, int width, int height, std::string& doubt);

/// Corrects a camera for pictures of this size: the same, and a stated size that contradicts the principal
/// point, near the real pictures' middle, is replaced. `doubt` gets what was changed.
Intrinsics trusted_intrinsics(Intrinsics camera, int width, int height, std::string& doubt);

/// Reads the cameras in these files (read_camera_file), one a frame, for pictures of this size. An error
/// names the file and the frame.
Result<std::vector<Camera>> read_frame_cameras(const PictureFiles& files, int width, int height);

/// One camera for one or more: each of its four numbers is the median (the lower of two in the middle).
Camera median_camera(std::span<const Camera> cameras);

/// Largest distance between the pixels that show a ray in two cameras' pictures, in columns and rows.
struct PixelShift {
    double columns = 0, rows = 0;
    bool is_inside = true;  ///< the stored picture has all that the clip's camera sees
    double length() const { return std::sqrt(columns * columns + rows * rows); }
    /// Whether the nearest pixel differs anywhere.
    bool moves() const { return columns >= 0.5 || rows >= 0.5; }
};
PixelShift shift_between(const Camera& clip, const Camera& stored, int width, int height);

/// Files in a folder of pictures with the camera of each frame.
struct GuessedCameras {
    std::string files;  ///< as `FolderSource::cameras`; a single file's name if there is only one
    Camera median;      ///< of those paired with depth pictures
};

/// Finds cameras' files as ARKitScenes has them (.pincam) in the folder or one of its folders: of several
/// kinds that for pictures of this size, otherwise the most frequent. Nothing if there are none; an error
/// names the file that cannot be read.
Result<std::optional<GuessedCameras>> guess_cameras(const std::filesystem::path& folder,
                                                    const std::string& depth_pattern, int width, int height);

/// The camera's poses, from a file beside pictures.
struct FoundPoses {
    CameraPath path;  ///< empty: the file is not understood, as `remark` says
    std::filesystem::path file{};
    std::string remark{};
};

/// Reads the first file with poses in a folder of pictures: poses.txt or groundtruth.txt (TUM RGB-D),
/// trajectory.log or another .log with "traj" in its name (Redwood, Open3D), or metadata.json (Record3D).
/// `rate`: of the frames. From a list with times each frame gets the nearest pose, at most 20 ms away; if
/// fewer than half fit and there are as many poses as frames, they go one by one. Nothing if there is no such
/// file.
std::optional<FoundPoses> poses_beside(const std::filesystem::path& folder, const PictureFiles& depth,
                                       const FrameRate& rate, double metres_per_unit);

/// A file beside pictures by which colour does not lie on depth's pixels: a matrix between depth's camera and
/// colour's (depth_M_color.txt, extrinsic_color.txt) other than the unit matrix; nothing if there is none.
std::optional<std::filesystem::path> colour_movement_in(const std::filesystem::path& folder);

/// Colour's camera as ViSP stores it, for pictures of this size: depth_M_color.txt (`movement`; to depth's
/// camera, metres), and colour's NAME.xml beside depth's NAME_depth.xml. Nothing for other files.
struct VispColourCamera {
    ColourCamera camera;
    std::filesystem::path file;
};
std::optional<VispColourCamera> visp_colour_camera(const std::filesystem::path& movement,
                                                   const std::filesystem::path& camera_of_depth, int width,
                                                   int height);

/// The file of a colour camera that sees depth's pixels elsewhere than the scene's camera; nothing if there
/// is none. A file that states no picture size is for `width` x `height` pixels.
std::optional<std::filesystem::path> camera_of_colour_in(const std::filesystem::path& folder,
                                                         const Scene& scene, int width, int height);

}  // namespace touchable
