// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writing clips: `convert`, and the commands that change a clip before they write it (relief, materials).
// run_convert reads a clip once, writes it in another form, and reports losses; ManyClips runs such a command
// on several clips, which go into one folder. All of it is for the main thread; files are written whole or
// not at all.

#include <CLI/CLI.hpp>
#include <array>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/run_files.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// A moment of a clip as typed: a frame's number or its time.
struct ClipMoment {
    std::int64_t frame = 0;
    std::optional<std::int64_t> time_ns{};  ///< replaces the number
};

/// Output form, determined by the file name.
enum class ClipForm {
    archive,     ///< NAME.mkv, NAME.mp4
    folder,      ///< a name without an extension, or that ends in /
    still,       ///< NAME.png: one frame
    scene_text,  ///< NAME.bt: one frame, a static scene as in the paper
    mp4_still,   ///< NAME.mp4 with --still: the same scene in one file
    gltf,        ///< NAME.gltf
    web,         ///< a folder, with --web: a page and its clip
    lerobot,     ///< NAME.mp4 with --lerobot: depth as stored by LeRobot
    floats,      ///< NAME.npy: depth of all frames as floats
    float_still  ///< NAME.exr: depth of one frame as floats
};
inline bool is_one_frame(ClipForm form) {
    return form == ClipForm::still || form == ClipForm::float_still || form == ClipForm::scene_text ||
           form == ClipForm::mp4_still;
}

struct ConvertOptions {
    ClipChoice clip;        ///< its filters are ignored unless `filtered`
    bool filtered = false;  ///< depth becomes what filters leave
    std::filesystem::path out;
    ClipForm form = ClipForm::archive;
    Existing existing = Existing::keep;
    ClipStorage storage{};           ///< of an archive
    std::optional<ClipMoment> from;  ///< the first frame; nothing: the clip's first
    std::optional<ClipMoment> to;    ///< the last frame, or the time at which it ends
    std::int64_t every = 1;
    std::optional<ClipPart::Crop> crop;
    std::optional<PixelSize> size;
    /// Changes the clip before it is written, for example adds relief; null: no change.
    std::function<Result<std::unique_ptr<ClipReader>>(std::unique_ptr<ClipReader>)> content{};
    std::vector<PlaneRole> made{};  ///< planes made by `content`; others are copied if possible
    bool still = false;             ///< --still: NAME.mp4 is a static scene
    bool lerobot = false;           ///< --lerobot: NAME.mp4 is LeRobot's video of depth
    bool web = false;               ///< --web: the folder is a page
    bool allow_lossy = false;       ///< values of touch planes may change
};

/// Writes a clip in another form, or a part of it. Depth, haptic and height keep every value; colour's loss
/// is printed. The output is read back and compared before it gets its name. The clip itself is read once. A
/// conversion that would lose more is refused (ErrorKind::usage) unless allowed; then its loss is printed.
Result<void> run_convert(const ConvertOptions& options);

/// CLIP OUT, or CLIP CLIP ... FOLDER/ like cp: several clips become NAME.mkv in the folder. Existing outputs
/// are skipped, so that interrupted work can be resumed and several programs may work on the same clips.
struct ManyClips {
    std::vector<std::filesystem::path> rest;  ///< further clips, then OUT

    /// Adds the words after CLIP and returns the option. `out`: description of OUT.
    CLI::Option* add_option(CLI::App& sub, const std::string& out);

    /// Whether OUT is a folder. `rest` must not be empty.
    bool is_for_several() const { return rest.size() > 1 || !rest.back().has_filename(); }

    /// Converts one clip; `out` gets its name last, so that a failure leaves no file.
    using One =
        std::function<Result<void>(const std::filesystem::path& clip, const std::filesystem::path& out)>;
    /// Calls `one` for each clip. With several clips a failure is printed at once and the others are still
    /// converted; then returns an error of the first failure's kind with the number of failures.
    Result<void> for_each(const std::filesystem::path& first, Existing existing, const One& one) const;
};

}  // namespace touchable
