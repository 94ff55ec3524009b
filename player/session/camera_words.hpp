#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/camera/plugged_camera.hpp"
#include "engine/clip/replay_camera.hpp"

namespace touchable {

/// A camera, as a person names one: one that is plugged in, a program that sends its frames, a stream, or a
/// recording that behaves like one.
struct LiveCamera {
    std::optional<PluggedChoice> plugged{};
    std::filesystem::path recording;
    CameraDelivery delivery;
};

/// Reads "v4l2:NODE[,key=value...]", "pipe:CMD", "tcp://HOST:PORT", "stream:ADDRESS" or
/// "replay:PATH[,key=value...]" (docs/camera.md); PATH ends with the first comma. Starts and opens nothing.
/// Refuses (ErrorKind::usage) what is no such description, and names what would be right.
Result<LiveCamera> read_live_camera(const std::string& words);

}  // namespace touchable
