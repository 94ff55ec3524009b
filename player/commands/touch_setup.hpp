#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "device/simulated_device.hpp"
#include "player/commands/touch_run.hpp"
#include "player/session/recording.hpp"
#include "player/session/touch_session.hpp"

namespace touchable {

/// Everything a session runs on, made from options or from a recording.
struct TouchSetup {
    std::filesystem::path clip;
    std::optional<std::filesystem::path> scene_file;
    std::optional<PictureCamera> camera;  ///< of a single depth picture
    std::string hand_words;               ///< as on the command line
    std::vector<std::string> notes;       ///< the reader's
    Scene scene;                          ///< as this run applies it
    BuilderChoice builder;                ///< not auto any more
    std::string builder_why;              ///< of what auto picked; empty: it was asked for by name
    std::unique_ptr<RunGpu> gpu;          ///< of builder and picture
    std::unique_ptr<SurfaceFeed> feed;
    std::unique_ptr<Hand> hand;
    std::string device_words;  ///< as on the command line; empty: no device
    std::unique_ptr<SimulatedDevice> device;
    Workspace workspace;
    std::optional<TouchSolver> solver;
    TouchSessionSettings settings;
    bool live = false;  ///< on the wall clock, or recorded so

    /// The clip, from its beginning.
    Result<std::unique_ptr<ClipReader>> open() const { return open_clip(clip, scene_file, camera); }
    /// What a recording keeps of it; `setup_from_recording` reads the same members.
    nlohmann::ordered_json facts() const;
};

Result<std::unique_ptr<TouchSetup>> setup_from_options(const TouchOptions& options);
/// The recorded run, over `options.clip` if that is given, with `options.builder`. `recording` outlives the
/// setup.
Result<std::unique_ptr<TouchSetup>> setup_from_recording(const Recording& recording,
                                                         const TouchOptions& options);

}  // namespace touchable
