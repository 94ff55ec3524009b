// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files of a folder of pictures: each plane's by a scene's patterns and lists, with the frame and time of
// each file; and, for a folder without a scene, the groups of pictures in it.

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The files of a plane, one a frame. The last file also serves all later frames: a still and a stack, which
/// may be described as millions of frames, have one file.
struct PictureFiles {
    std::vector<std::filesystem::path> files;
    /// The numbers in their names or the times of a list, which order them; one a file, or none.
    std::vector<double> keys;
    bool has_decimals = false;   ///< keys were written with a point: they are seconds, even if whole
    std::filesystem::path list;  ///< the list that names them, if one does
    std::string remark;          ///< on missing numbers and impossible times

    std::size_t frames = 0;  ///< if more than files

    std::size_t count() const { return std::max(frames, files.size()); }
    const std::filesystem::path& file(std::size_t frame) const {
        return files[std::min(frame, files.size() - 1)];
    }
};

/// The files in `folder` that match the depth pattern of `source` (FolderSource). The remark names missing
/// numbers. An error names the file that is missing.
Result<PictureFiles> depth_files(const std::filesystem::path& folder, const FolderSource& source);

/// Another plane's file for each of `depth`: that with the same number, the nearest by key if both have keys,
/// otherwise that at the same position; or one still for all. The remark names numbers that only depth has.
Result<PictureFiles> files_beside(const std::filesystem::path& folder, PlaneRole role,
                                  const FolderSource& source, const PictureFiles& depth);

/// The file of `source.cameras` for each of `depth`, paired in the same way.
Result<PictureFiles> camera_files(const std::filesystem::path& folder, const FolderSource& source,
                                  const PictureFiles& depth);

/// The files of a star pattern or of a list.
Result<PictureFiles> found_files(const std::filesystem::path& folder, const std::string& pattern);

/// Index of the nearest of the sorted keys, one or more.
std::size_t nearest_key(const std::vector<double>& keys, double key);

/// Seconds of the unit of a time since 1970 or earlier, which its size tells: nano-, micro- or milliseconds,
/// ticks of 100 ns; otherwise 1.
double seconds_of_stamp(double stamp);

/// The rate of frames with these times, which must not go backward: even if all keep to the median step
/// within 2 ms, otherwise their own times, or even at the mean step if some are less than 1 ms apart. Nothing
/// for fewer than two, and if they are no times of frames.
std::optional<FrameRate> rate_of_seconds(const std::vector<double>& seconds);
/// The times of pictures, seconds, from a list or their names; empty if keys are no times.
std::vector<double> seconds_of_day(const PictureFiles& pictures);
/// `rate_of_seconds` of pictures whose keys are times.
std::optional<FrameRate> rate_of(const PictureFiles& pictures);
/// Why the times of a list cannot be used; empty if they can, or if there is no list of times.
std::string unusable_times(const PictureFiles& pictures);
/// Their own times whenever possible, even if evenly spaced: a clip written with a list loses no nanosecond.
std::optional<FrameRate> own_rate_of(const PictureFiles& pictures);

/// Pictures of a folder whose names differ only by a number.
struct PictureGroup {
    std::string pattern;  ///< relative to the folder: a star for the number; or a list; or a single file
    std::filesystem::path first;
    std::size_t count = 0;
};

/// The groups in the folder and its subfolders, or, if these have none, in their subfolders; largest first.
/// Lists of pictures (depth.txt, rgb.txt) come first, organised clouds, which are made of pictures, last.
std::vector<PictureGroup> picture_groups(const std::filesystem::path& folder);

/// The files with the cameras of frames, grouped in the same way (ARKitScenes' .pincam).
std::vector<PictureGroup> camera_groups(const std::filesystem::path& folder);

/// NumPy arrays that are named as cameras' matrices (K.npy, intrinsics.npz) and so are no pictures, grouped
/// in the same way.
std::vector<PictureGroup> camera_arrays(const std::filesystem::path& folder);

/// Groups of HDF5 files whose names do not say so (Spring's .dsp5), by their first bytes.
std::vector<PictureGroup> hdf5_groups(const std::filesystem::path& folder);

/// Whether a pattern is a list of files and their times.
bool is_list(const std::string& pattern);

/// Why lists in the folder cannot be used, a remark for each.
std::vector<std::string> unusable_lists(const std::filesystem::path& folder);

/// Where depth may be if `folder` has no pictures: how to open a video in it or a folder further down, in
/// words that follow "there is no picture"; empty: nowhere.
std::string found_elsewhere(const std::filesystem::path& folder);

/// The folder in a group's pattern, with its slash; empty: the searched folder itself.
std::string folder_of(const PictureGroup& group);

/// Whether a file's name ends as a picture's or a cloud's.
bool is_named_as_picture(const std::filesystem::path& file);

/// Whether `file` exists and is a regular file.
bool is_file(const std::filesystem::path& file);

/// Whether a name, ignoring its case, contains one of these words.
bool has_word(const std::string& name, std::initializer_list<const char*> words);

}  // namespace touchable
