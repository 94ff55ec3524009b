#pragma once

#include <CLI/CLI.hpp>

#include <optional>

#include "engine/result.hpp"
#include "player/session/session_options.hpp"

namespace touchable {

/// --camera: what is touched in place of CLIP.
CLI::Option* add_live_camera_option(CLI::App& sub, SessionOptions& session);

/// --stale-after, ms.
CLI::Option* add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds);

/// The camera that was typed, if one was, as the session's clip. Refused (ErrorKind::usage) beside a CLIP.
Result<void> read_live_camera(bool has_clip, const std::optional<double>& stale_after_ms,
                              SessionOptions& session);

}  // namespace touchable
