#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// What stands in for the scene file of pictures, as typed.
struct CameraTyped {
    std::optional<std::string> intrinsics, preset;
    std::optional<double> fov, depth_unit;
    std::optional<double> least_confidence;  ///< of add_clip_options
};

/// --intrinsics, --fov, --depth-unit and --preset, which exclude --scene where `sub` has that already.
std::vector<CLI::Option*> add_camera_options(CLI::App& sub, CameraTyped& typed);

/// Nothing where none was typed. Refused (ErrorKind::usage) where numbers are none; a camera's file is read.
Result<std::optional<SourceDescription>> read_camera(const CameraTyped& typed);

}  // namespace touchable
