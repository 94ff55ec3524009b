#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "engine/base/result.hpp"
#include "player/session/session_options.hpp"

namespace touchable {

/// --camera: what is touched in place of CLIP.
CLI::Option* add_live_camera_option(CLI::App& sub, SessionOptions& session);

/// --stale-after, ms.
CLI::Option* add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds);

/// --latency.
CLI::Option* add_latency_option(CLI::App& sub, SessionOptions& session);

/// CLIP, where it is a stream and the run is live, as the session's camera. A file on a web server stays a
/// clip. Refused (ErrorKind::usage) is a latency of anything else.
Result<void> read_live_stream(bool has_latency, SessionOptions& session);

/// The camera that was typed, if one was, as the session's clip. Refused (ErrorKind::usage) beside a CLIP.
Result<void> read_live_camera(bool has_clip, const std::optional<double>& stale_after_ms,
                              SessionOptions& session);

}  // namespace touchable
