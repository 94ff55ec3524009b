#pragma once

#include <filesystem>
#include <string>

#include "engine/media/replay_camera.hpp"
#include "engine/result.hpp"

namespace touchable {

/// A camera, as a person names one.
struct LiveCamera {
    std::filesystem::path recording;
    CameraDelivery delivery;
};

/// Reads "replay:PATH[,key=value...]" (docs/camera.md); PATH ends with the first comma. Refuses
/// (ErrorKind::usage) what is no such description, and names what would be right.
Result<LiveCamera> read_live_camera(const std::string& words);

}  // namespace touchable
