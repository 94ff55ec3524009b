#pragma once

// The files of a folder of pictures: those of each plane by a scene's patterns and lists, which frame each is
// of and when that was taken; and, of a folder that no scene describes, which rows of pictures it has.

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The files of a plane, one a frame. The last serves all frames that come after it as well: a still and a
/// stack, which may be described as millions of frames, have one file.
struct PictureFiles {
    std::vector<std::filesystem::path> files;
    /// What orders them, if anything: numbers in their names, or the times of a list. As many as files.
    std::vector<double> keys;
    bool has_decimals = false;   ///< keys were written with a point: they are seconds, even if whole
    std::filesystem::path list;  ///< that names them, if one does
    std::string remark;          ///< of numbers that are missing, and of times that cannot be

    std::size_t frames = 0;  ///< where they are more than files

    std::size_t count() const { return std::max(frames, files.size()); }
    const std::filesystem::path& file(std::size_t frame) const {
        return files[std::min(frame, files.size() - 1)];
    }
};

/// What the depth pattern of `source` stands for in `folder` (FolderSource). Its remark says which numbers a
/// row lacks. An error names what is missing.
Result<PictureFiles> depth_files(const std::filesystem::path& folder, const FolderSource& source);

/// A file of another plane for each of `depth`: that of the same number, that which is nearest by key where
/// both have keys, otherwise that of the same place in its row; or the same still for all. Its remark says
/// which of depth's numbers it has not.
Result<PictureFiles> files_beside(const std::filesystem::path& folder, PlaneRole role,
                                  const FolderSource& source, const PictureFiles& depth);

/// The file of `source.cameras` for each of `depth`, paired in the same way.
Result<PictureFiles> camera_files(const std::filesystem::path& folder, const FolderSource& source,
                                  const PictureFiles& depth);

/// The files of a star pattern or a list alone.
Result<PictureFiles> found_files(const std::filesystem::path& folder, const std::string& pattern);

/// The place of the nearest of sorted keys, of which there is one.
std::size_t nearest_key(const std::vector<double>& keys, double key);

/// When frames with these times, which do not go backward, were taken: evenly, where all keep to the median
/// step within 2 ms, otherwise at their own times, or where some are less than 1 ms apart evenly at their
/// mean. Nothing of fewer than two, and where they are no times of frames.
std::optional<FrameRate> rate_of_seconds(const std::vector<double>& seconds);
/// The times of pictures, seconds, as a list or their names have them; empty where keys are no times.
std::vector<double> seconds_of_day(const PictureFiles& pictures);
/// `rate_of_seconds` of pictures whose keys are times.
std::optional<FrameRate> rate_of(const PictureFiles& pictures);
/// Why the times of a list are of no use; empty where they are, and where there is no list of times.
std::string unusable_times(const PictureFiles& pictures);
/// Their own times wherever they can be, however even: to a clip that was written as a list not a nanosecond
/// is lost.
std::optional<FrameRate> own_rate_of(const PictureFiles& pictures);

/// Pictures of a folder whose names differ by a number alone.
struct PictureGroup {
    std::string pattern;  ///< from the folder, with a star for the number; or a list; or a single file's name
    std::filesystem::path first;
    std::size_t count = 0;
};

/// Of the folder itself and of those in it, or where these have none of those in them, largest first; lists
/// of pictures (depth.txt, rgb.txt) before those that they name, and organised clouds, which are made of
/// pictures, last.
std::vector<PictureGroup> picture_groups(const std::filesystem::path& folder);

/// The files with the cameras of frames, grouped in the same way (ARKitScenes' .pincam).
std::vector<PictureGroup> camera_groups(const std::filesystem::path& folder);

/// Arrays of NumPy that are named as cameras' matrices (K.npy, intrinsics.npz), grouped in the same way: they
/// are no pictures.
std::vector<PictureGroup> camera_arrays(const std::filesystem::path& folder);

/// Whether a pattern is a list of files and their times.
bool is_list(const std::string& pattern);

/// Why lists in the folder cannot be used, a remark for each.
std::vector<std::string> unusable_lists(const std::filesystem::path& folder);

/// Where pictures may be if not in `folder`: how to open a video in it, or a folder further down, in words
/// that follow "there is no picture"; empty: nowhere.
std::string found_elsewhere(const std::filesystem::path& folder);

/// Whether a file is a recording of Record3D in its own format, which is not read.
bool is_record3d(const std::filesystem::path& file);

/// The folder in a group's pattern, with its slash; empty: that which was looked through itself.
std::string folder_of(const PictureGroup& group);

/// Whether a file's name ends as those of pictures of a folder do, or of clouds.
bool is_named_as_picture(const std::filesystem::path& file);

/// Whether a regular file is there.
bool is_file(const std::filesystem::path& file);

/// Whether a name, in small letters, has one of these words.
bool has_word(const std::string& name, std::initializer_list<const char*> words);

}  // namespace touchable
