#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "engine/camera/frameset_camera.hpp"
#include "engine/camera/v4l2_camera.hpp"
#include "engine/stream/live_stream.hpp"

namespace touchable {

/// A camera that is there now, or a stream, by whom its frames come.
using PluggedChoice = std::variant<V4l2Choice, FramesetChoice, StreamChoice>;

/// As a person names it: its node, "pipe:CMD", "tcp://HOST:PORT", a stream's address.
std::string name_of(const PluggedChoice& choice);

/// As `open_v4l2_camera`, `open_frameset_camera` and `open_live_stream`, which says itself what its depth
/// means.
Result<std::unique_ptr<ClipReader>> open_plugged_camera(
    const PluggedChoice& choice, const std::optional<SourceDescription>& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

}  // namespace touchable
