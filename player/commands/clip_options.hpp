#pragma once

#include <CLI/CLI.hpp>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What stands in for the scene file of pictures, as typed.
struct CameraTyped {
    std::optional<std::string> intrinsics, preset;
    std::optional<double> fov, depth_unit;
    std::optional<DepthSemantics> depth;
    std::optional<double> least_confidence;  ///< of add_clip_options
    std::optional<std::string> channel;      ///< likewise
    std::optional<std::string> dataset;      ///< likewise
};

/// --intrinsics, --fov, --depth-unit, --depth and --preset, which exclude --scene where `sub` has that
/// already.
void add_camera_options(CLI::App& sub, CameraTyped& typed);

/// Nothing where none was typed. Refused (ErrorKind::usage) where numbers are none; a camera's file is read.
Result<std::optional<SourceDescription>> read_camera(const CameraTyped& typed);

/// --filters: auto, off, or those that shall be on, as `FilterSetting::in_list` has them, with commas
/// between. Refused (ErrorKind::usage) where it is none of these.
Result<FiltersChoice> read_filters(const std::string& typed);

/// Which clip, and as what: as typed.
struct ClipTyped {
    ClipChoice choice;  ///< but for the camera
    CameraTyped camera;
};

/// CLIP, which is given back, --scene, --haptic, --height, --align, --fill-from-motion,
/// --least-confidence, --channel and --dataset. For a single depth picture add_camera_options goes with them.
CLI::Option* add_clip_options(CLI::App& sub, ClipTyped& typed);

/// --filters, and an option for each filter that has one (filter_settings).
std::vector<CLI::Option*> add_filter_options(CLI::App& sub, ClipTyped& typed);

/// Refused (ErrorKind::usage) where words are not what they should be.
Result<ClipChoice> read_clip(const ClipTyped& typed);

/// --camera: what is touched in place of CLIP.
void add_live_camera_option(CLI::App& sub, SessionOptions& session);

/// --stale-after, ms.
void add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds);

/// --latency.
CLI::Option* add_latency_option(CLI::App& sub, SessionOptions& session);

/// CLIP, where it is a stream and the run is live, as the session's camera. A file on a web server stays a
/// clip. Refused (ErrorKind::usage) is a latency of anything else.
Result<void> read_live_stream(bool has_latency, SessionOptions& session);

/// The camera that was typed, if one was, as the session's clip. Refused (ErrorKind::usage) beside a CLIP.
Result<void> read_live_camera(bool has_clip, const std::optional<double>& stale_after_ms,
                              SessionOptions& session);

}  // namespace touchable
