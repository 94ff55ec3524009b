// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds colour videos by their names: beside a depth video (walk_rgb.avi beside walk_depth.mkv) and beside
// depth pictures (rgb.mp4 beside depth/*.png).

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/clip/tracks.hpp"

namespace touchable {

/// Whether a name ends as a video's.
bool is_named_as_video(const std::filesystem::path& file);

/// Whether a video's name has a word for depth (depth, disp, vis).
bool is_named_as_depth_video(const std::filesystem::path& file);

/// All videos of a folder, by name.
std::vector<std::filesystem::path> video_files_in(const std::filesystem::path& folder);

/// A colour video.
struct ColourVideo {
    std::string name;  ///< file name
    std::shared_ptr<VideoFile> file;
    std::vector<std::string> others{};  ///< names of other videos that could be colour
};
/// The video named as `depth` without its word for depth, or with a word for colour in its place, ignoring
/// case; nothing if no such file opens as a video.
std::optional<ColourVideo> colour_video_beside(const std::filesystem::path& depth);

/// The colour video in a folder of depth pictures with `frames` frames, found by its name or as the only one,
/// with as many frames; nothing if there is none.
std::optional<ColourVideo> colour_video_in(const std::filesystem::path& folder, std::int64_t frames);

}  // namespace touchable
