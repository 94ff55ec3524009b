#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/commands/camera_options.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// Which clip, and as what: as typed.
struct ClipTyped {
    ClipChoice choice;  ///< but for what stands below
    CameraTyped camera;
    std::optional<std::string> filters, temporal;
};

/// CLIP, which is given back, --scene, --haptic, --height, --align, --fill-from-motion and
/// --least-confidence. For a single depth picture add_camera_options goes with them.
CLI::Option* add_clip_options(CLI::App& sub, ClipTyped& typed);

/// --filters, --median, --fill-holes, --terraces and --temporal.
std::vector<CLI::Option*> add_filter_options(CLI::App& sub, ClipTyped& typed);

/// Refused (ErrorKind::usage) where words are not what they should be.
Result<ClipChoice> read_clip(const ClipTyped& typed);

}  // namespace touchable
