// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "player/commands/option_types.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// Camera options of pictures without a scene file, as typed.
struct CameraTyped {
    SourceDescription known;                ///< without intrinsics
    std::optional<std::string> intrinsics;  ///< numbers, or a file with them
};

/// Adds --intrinsics and the options of what describes pictures (SourceSetting::describes). They exclude
/// --scene if `sub` already has it.
void add_camera_options(CLI::App& sub, CameraTyped& typed);

/// Reads a camera's file. Invalid numbers are refused (ErrorKind::usage).
Result<SourceDescription> read_camera(const CameraTyped& typed);

/// --filters: auto, off, or a comma-separated list of filters to enable (`FilterSetting::in_list`). Anything
/// else is refused (ErrorKind::usage).
Result<ClipChoice::Filters> read_filters(const std::string& typed);

/// The clip and its options, as typed.
struct ClipTyped {
    ClipChoice choice;  ///< without the camera
    CameraTyped camera;
    bool filtered = false;               ///< --filtered, of commands that have it
    bool filters_need_filtered = false;  ///< other filters have no effect
};

/// Adds CLIP, which is returned, --scene, --haptic, --height, --align, --fill-from-motion, and the options of
/// what is stated beside a scene, such as --channel. A single depth picture also needs add_camera_options.
CLI::Option* add_clip_options(CLI::App& sub, ClipTyped& typed);

/// Adds --filters and an option for each filter that has one (filter_settings).
void add_filter_options(CLI::App& sub, ClipTyped& typed);

/// Adds --filtered, and filters that are for it alone. `verb`: what becomes of the depth that they leave.
void add_filtered_options(CLI::App& sub, ClipTyped& typed, const std::string& verb);

/// Invalid words are refused (ErrorKind::usage).
Result<ClipChoice> read_clip(const ClipTyped& typed);

/// Makes a clip that is a stream's address a live source; a file on a web server stays a clip.
Result<void> choose_stream(ClipChoice& clip);

/// Every file from which a clip is read.
std::vector<NamedFile> inputs_of(const ClipChoice& clip, const ClipReader& reader);

/// A live source, as typed beside SessionOptions::camera.
struct LiveTyped {
    std::optional<double> stale_after_ms;
    int latency_ms = 200;  ///< of a stream: longest time that a frameset waits for others
    const CLI::Option* latency = nullptr;
};

/// Adds --camera, which is touched in place of CLIP, --latency and --stale-after, ms.
void add_live_options(CLI::App& sub, LiveTyped& typed, SessionOptions& session);

/// Makes a typed --camera the session's clip, or CLIP the session's camera if it is a stream and the run is
/// live; a file on a web server stays a clip. Refused (ErrorKind::usage): --camera together with a CLIP,
/// --latency without a stream.
Result<void> read_live_options(const LiveTyped& typed, SessionOptions& session);

}  // namespace touchable
