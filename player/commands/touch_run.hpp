#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "player/commands/device_options.hpp"
#include "player/commands/picture_options.hpp"
#include "player/session/session_options.hpp"

namespace touchable {

/// A run, and what is written of it.
struct TouchOptions {
    /// With `replay` only the builder and the clip, which may be empty: the recorded one then.
    SessionOptions session;
    HeldDeviceWords held;
    std::optional<std::filesystem::path> json, forces, record, replay, device_log;
    std::optional<std::filesystem::path> play;  ///< read into `session.playback` already
    Existing existing = Existing::keep;         ///< what becomes of earlier files of those names
    bool verbose = false;                       ///< prints the whole table
    bool strict = false;                        ///< what the report warns of is an error of kind check
    PictureOptions picture;
    std::optional<std::int64_t> picture_tick;  ///< nothing: usual_picture_tick
};

/// Touches a clip at 1 kHz, of virtual time or (live) of the wall clock, prints a table, and writes what was
/// asked for. With `replay`, does again what a recording holds: a first different force is an error of kind
/// check that names tick and finger. A live run that a person ends is complete, and an error that says how
/// long it was.
Result<void> run_touch(const TouchOptions& options);

}  // namespace touchable
