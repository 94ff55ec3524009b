#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace touchable {

/// Pictures of a folder whose names differ by a number alone.
struct PictureGroup {
    std::string pattern;  ///< from the folder, with a star for the number; or a list; or a single file's name
    std::filesystem::path first;
    std::size_t count = 0;
};

/// Of the folder itself and of those in it, largest first; lists of pictures (depth.txt, rgb.txt) before
/// those that they name.
std::vector<PictureGroup> picture_groups(const std::filesystem::path& folder);

/// Where else a person's pictures may be: how to open a video in `folder`, or the folders further down that
/// have pictures, in words behind "there is no picture"; empty: nowhere.
std::string found_elsewhere(const std::filesystem::path& folder);

/// Likewise the files with the cameras of frames (ARKitScenes' .pincam).
std::vector<PictureGroup> camera_groups(const std::filesystem::path& folder);

/// Of lists there that cannot be used: why not.
std::vector<std::string> unusable_lists(const std::filesystem::path& folder);

/// The folder in a group's pattern, with its slash; empty: that which was looked through itself.
std::string folder_of(const PictureGroup& group);

/// Whether a name, in small letters, has one of these words.
bool has_word(const std::string& name, std::initializer_list<const char*> words);

}  // namespace touchable
