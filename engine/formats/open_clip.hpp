// SPDX-License-Identifier: Apache-2.0
#pragma once

// Opens clips of every kind: our own in Matroska and MP4, glTF, texts of MPEG-4 scenes, recordings of cameras
// and of ROS, photographs of phones, videos and pictures of depth, folders of pictures, streams.
//
// `open_clip` recognises a file by its first bytes, in the order of `clip_formats`, and returns a ClipReader
// at the clip's beginning. What a file does not say of its depth and its camera comes from a scene file, or
// from a SourceDescription, which is what a person knows of them; the rest is guessed: camera, unit, coding,
// rate, and which files are depth and which are colour. Each guess is a remark in the reader's scene, with
// the settings that override it, so that a program can show what was assumed. `guess_clip` returns that
// description alone, to be written as a scene file and corrected.
//
//   TRY_ASSIGN(const auto guessed, guess_clip("pictures", known));
//   for (const Remark& remark : guessed.scene.remarks) show(remark);
//
// Threads: any may call all functions, also several at once; one at a time uses a reader. Functions wait for
// disks and servers: once the thread is asked to stop (stop_requested), the result is soon an error of kind
// interrupted. Errors are one line with the file's name; below `player/commands` they name a Setting, never
// an option.

#include <filesystem>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// A kind of clip that can be opened.
struct ClipFormat {
    const char* what;     ///< in words
    const char* command;  ///< how it is opened, such as "touchable play FOLDER"
    Hints settings{};     ///< settings of that command
};
/// All formats, in the order in which they are tried.
std::vector<ClipFormat> clip_formats();

/// Whether a file's name ends as a video's or a recording's. Pictures' do not: most are frames of a clip.
bool is_named_as_clip(const std::filesystem::path& file);

/// Guesses the scene of a path that has no scene file: a folder of pictures, a depth picture or video, a
/// recording. For a clip of ours, returns the scene in it. What only the whole clip tells is left open
/// (unstated); a reader settles it.
Result<SceneDescription> guess_clip(const std::filesystem::path& path, const SourceDescription& known);

/// Opens a file, a folder, a URL, or a scene file, whose patterns are relative to it. A folder is described
/// by `scene_file`, by a scene.json in it, or by `known` and guesses. If the clip has a scene of its own,
/// `scene_file` replaces it. Colour that is left out need not be decoded. `alignment` applies to depth
/// without a scale (with_aligned_depth); `on` applies it to any clip that can have it.
Result<std::unique_ptr<ClipReader>> open_clip(const std::filesystem::path& path,
                                              const std::optional<std::filesystem::path>& scene_file = {},
                                              const SourceDescription& known = {},
                                              Colour colour = Colour::wanted,
                                              DepthAlignment alignment = DepthAlignment::automatic);

/// Opens the depth video in `folder` that the scene's VideoSource names, without its colour.
Result<std::unique_ptr<ClipReader>> open_video_clip(const std::filesystem::path& folder,
                                                    const SceneDescription& described);

}  // namespace touchable
