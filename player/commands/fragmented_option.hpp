#pragma once

#include <CLI/CLI.hpp>

#include "engine/clip/matroska_writer.hpp"

namespace touchable {

/// What --fragmented is for, where it is refused.
inline constexpr const char* fragmented_names = "NAME.mp4; no other form is written in fragments";

/// --fragmented, of the commands that write clips.
inline const CLI::Option* add_fragmented_option(CLI::App& command, ClipStorage& storage) {
    return command.add_flag(
        "--fragmented", storage.fragmented,
        "of NAME.mp4: in pieces of half a second, as it is sent; a copy that is cut is readable up to there. "
        "Without an MPEG-4 scene (docs/mpeg4.md)");
}

}  // namespace touchable
