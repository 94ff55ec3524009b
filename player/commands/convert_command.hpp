#pragma once

// Writing clips: `convert`, and the commands that make something of a clip before they write it (relief,
// materials). run_convert reads a clip once, writes it in another form, and says what was lost; ManyClips
// does the work of one such command on several clips, which go into one folder. PlaneLoss is how a loss is
// measured. All of it is for the main thread; files are written whole or not at all.

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>

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

/// A moment of a clip as a person says it: the number of a frame, or its time.
struct ClipMoment {
    std::int64_t frame = 0;
    std::optional<std::int64_t> time_ns{};  ///< in place of the number
};

/// What a clip becomes, by its name.
enum class ClipForm {
    archive,     ///< NAME.mkv, NAME.mp4
    folder,      ///< a name without an extension, or that ends in /
    still,       ///< NAME.png: one frame
    scene_text,  ///< NAME.bt: one frame, as the paper sends a static scene
    mp4_still,   ///< NAME.mp4 with --still: the same in one file
    gltf,        ///< NAME.gltf
    lerobot      ///< NAME.mp4 with --lerobot: depth as LeRobot has it
};
inline bool is_one_frame(ClipForm form) {
    return form == ClipForm::still || form == ClipForm::scene_text || form == ClipForm::mp4_still;
}

struct ConvertOptions {
    ClipChoice clip;  ///< of which filters do not count
    std::filesystem::path out;
    ClipForm form = ClipForm::archive;
    Existing existing = Existing::keep;
    ClipStorage storage{};           ///< of an archive
    std::optional<ClipMoment> from;  ///< the first frame; nothing: the clip's
    std::optional<ClipMoment> to;    ///< the last frame, or the time at which it ends
    std::int64_t every = 1;
    std::optional<ClipPart::Crop> crop;
    std::optional<PixelSize> size;
    /// What is made of the clip before it is written, such as relief; nothing: the clip as it is.
    std::function<Result<std::unique_ptr<ClipReader>>(std::unique_ptr<ClipReader>)> content{};
    std::vector<PlaneRole> made{};  ///< planes that `content` makes; all others are copied where they can be
    bool still = false;             ///< --still: NAME.mp4 is a static scene
    bool lerobot = false;           ///< --lerobot: NAME.mp4 is LeRobot's video of depth
    bool allow_lossy = false;       ///< that values of what is touched may change
};

/// Writes a clip in another form, or a part of it. Depth, haptic and height keep every value: what is written
/// is read again and compared before it gets its name; colour too, and what it loses is printed. The clip
/// itself is read once. A conversion that would lose more is refused (ErrorKind::usage) unless that is
/// allowed; then the loss is printed.
Result<void> run_convert(const ConvertOptions& options);

/// What values of one plane became: of each pixel as it was, and the nearest one that there is now.
struct PlaneLoss {
    std::int64_t samples = 0, changed = 0;
    int largest = 0;     ///< of a stored value
    double squares = 0;  ///< of them, summed up
    // Of depth.
    bool is_recoded = false;                        ///< values mean something else now: depths are compared
    std::int64_t pixels = 0;                        ///< that have a depth in both
    double largest_metres = 0, squares_metres = 0;  ///< of these
    std::int64_t appeared = 0, disappeared = 0;     ///< pixels that have a depth, and had none; and had one

    double rms() const { return samples > 0 ? std::sqrt(squares / static_cast<double>(samples)) : 0; }
    double rms_metres() const {
        return pixels > 0 ? std::sqrt(squares_metres / static_cast<double>(pixels)) : 0;
    }
};

/// By PlaneRole.
using PlaneLosses = std::array<PlaneLoss, all_roles.size()>;

/// Adds what became of a frame of the scene `before` in one of the scene `now`, whose values mean the same;
/// sizes may differ.
void add_loss(const RawFrame& before, const RawFrame& now, const Scene& scene, PlaneLosses& losses);

/// What was done, for a person.
struct Converted {
    std::vector<std::string> notes;  ///< remarks on the clip that was read
    Scene scene;                     ///< of what was written
    std::vector<TrackInfo> tracks;   ///< that it has
    std::int64_t frames = 0;
    PlaneLosses losses;
    std::string sound;                      ///< what became of it; empty: there is none
    std::optional<ForceComparison> forces;  ///< where values of what is touched were lost
};

std::string report_to_text(const ConvertOptions& options, const Converted& done);

/// CLIP OUT, or CLIP CLIP ... FOLDER/ as cp has it: what several clips become lies in the folder, as
/// NAME.mkv. One that is there already is left out, so that work goes on where it was stopped, and several
/// programs may work on the same clips.
struct ManyClips {
    std::vector<std::filesystem::path> rest;  ///< further clips, then OUT

    /// Adds the words after CLIP, and gives them back. `out`: what OUT is.
    CLI::Option* add_option(CLI::App& sub, const std::string& out);

    /// Whether OUT is to be a folder. `rest` is not empty.
    bool is_for_several() const { return rest.size() > 1 || !rest.back().has_filename(); }

    /// Names `out` last: what fails before that leaves none.
    using One =
        std::function<Result<void>(const std::filesystem::path& clip, const std::filesystem::path& out)>;
    /// Does `one` for each of them. Of several, the error of one that fails is printed at once, and the
    /// others are done; then the error is the first one's, with their number.
    Result<void> for_each(const std::filesystem::path& first, Existing existing, const One& one) const;
};

}  // namespace touchable
