#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/import/open_clip.hpp"
#include "engine/result.hpp"

namespace touchable {

/// What stands in for the scene file of a single depth picture, as typed.
struct CameraTyped {
    std::optional<std::string> intrinsics;
    std::optional<double> depth_unit;
};

/// --intrinsics and --depth-unit, which exclude --scene, an option of `sub` already.
std::vector<CLI::Option*> add_camera_options(CLI::App& sub, CameraTyped& typed);

/// Nothing where neither was typed. Refused (ErrorKind::usage) where the numbers are none.
Result<std::optional<PictureCamera>> read_camera(const CameraTyped& typed);

}  // namespace touchable
