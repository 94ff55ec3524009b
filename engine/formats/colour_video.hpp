#pragma once

// Videos of colour beside depth, by their names: beside a video of depth (walk_rgb.avi beside walk_depth.mkv)
// and beside pictures of depth (rgb.mp4 beside depth/*.png).

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/clip/tracks.hpp"

namespace touchable {

/// Whether a name ends as those of videos do.
bool is_named_as_video(const std::filesystem::path& file);

/// Whether a video's name has a word for depth (depth, disp, vis).
bool is_named_as_depth_video(const std::filesystem::path& file);

/// All videos of a folder, by name.
std::vector<std::filesystem::path> video_files_in(const std::filesystem::path& folder);

/// A video of colour, and how it was found.
struct ColourVideo {
    std::string name;  ///< in its folder
    std::shared_ptr<VideoFile> file;
    bool is_named = false;              ///< by its name; else as the only one, of as many frames as depth
    std::vector<std::string> others{};  ///< names of those that could be colour as well
};
/// The video whose name is that of `depth` without its word for depth, or with a word for colour in its
/// place, whatever the case; nothing where no such file is a video.
std::optional<ColourVideo> colour_video_beside(const std::filesystem::path& depth);

/// Of a folder with pictures of depth of so many frames; nothing where none is.
std::optional<ColourVideo> colour_video_in(const std::filesystem::path& folder, std::int64_t frames);

}  // namespace touchable
