#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_part.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/clip/plane_role.hpp"
#include "player/commands/typed_numbers.hpp"
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
    std::optional<PixelBox> crop;
    std::optional<PixelSize> size;
    /// What is made of the clip before it is written, such as relief; nothing: the clip as it is.
    std::function<Result<std::unique_ptr<ClipReader>>(std::unique_ptr<ClipReader>)> content{};
    std::vector<PlaneRole> made{};  ///< planes that `content` makes; all others are copied where they can be
    bool still = false;             ///< --still: NAME.mp4 is a static scene
    bool lerobot = false;           ///< --lerobot: NAME.mp4 is LeRobot's video of depth
    bool allow_lossy = false;       ///< that values of what is touched may change
};

/// Writes a clip in another form, or a part of it. Depth, haptic and height keep every value: what is written
/// is read again and compared before it gets its name; colour too, and what it loses is told. The clip itself
/// is read once. What would lose
/// more is refused (ErrorKind::usage) unless that is allowed, and then what is lost is told.
Result<void> run_convert(const ConvertOptions& options);

}  // namespace touchable
