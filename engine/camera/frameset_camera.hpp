#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// A program that sends framesets (frameset_format.hpp): a command that is started, or one that listens.
struct FramesetChoice {
    std::string command{};  ///< of /bin/sh; empty: `address`
    std::string address{};  ///< as connect_to takes it
    /// Before a run: for the first byte, and from then on for each frameset.
    std::chrono::milliseconds first_patience{30'000}, patience{10'000};

    std::string name() const { return command.empty() ? "tcp://" + address : "pipe:" + command; }
};

/// What it sends as a live source, as `open_v4l2_camera` gives a camera's, but that the sender says its unit
/// and its lens; where somebody else does, these count (`known`, `scene_file`). Frames are timed by
/// SenderClock. The command ends with the reader.
Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const std::optional<SourceDescription>& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

}  // namespace touchable
