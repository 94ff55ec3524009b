#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/media/clip.hpp"
#include "engine/new_file.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "player/commands/picture_options.hpp"
#include "player/session/builder_choice.hpp"

namespace touchable {

struct TouchOptions {
    std::filesystem::path clip;  ///< may be empty with `replay`: the recorded one then
    std::optional<std::filesystem::path> scene;
    std::optional<PictureCamera> camera;  ///< of a single depth picture
    std::string hand = "wander";
    int fingers = 1;
    std::optional<std::int64_t> ticks;  ///< nothing: the hand's length, or the clip's and at least 3 s
    BuilderChoice builder{.name = "auto"};
    TouchMetric metric = TouchMetric::world;
    double stribeck_speed = 0;                        ///< m/s; 0: friction does not depend on speed
    std::optional<int> median, fill_holes;            ///< instead of the scene's own
    std::optional<TerraceRemoval> terraces;           ///< likewise
    std::optional<std::string> temporal;              ///< likewise, as typed (apply_temporal)
    std::optional<FrameInterpolation> interpolation;  ///< likewise
    GuardSettings guard;
    bool live = false;                  ///< on the wall clock, in real time
    bool start_buried = false;          ///< live: force from the start for a finger that begins inside, too
    std::optional<std::string> device;  ///< live: what the hand holds; nothing: the hand itself is the finger
    std::optional<std::filesystem::path> json, forces, record, replay;
    Existing existing = Existing::keep;  ///< what becomes of earlier files of those names
    bool strict = false;                 ///< what the report warns of is an error of kind check
    PictureOptions picture;
    std::optional<std::int64_t> picture_tick;  ///< nothing: usual_picture_tick
};

/// Touches a clip at 1 kHz, of virtual time or (live) of the wall clock, prints a table, and writes what was
/// asked for. With `replay`, does again what a recording holds: a first different force is an error of kind
/// check that names tick and finger. A live run that a person ends is complete, and an error that says how
/// long it was.
Result<void> run_touch(const TouchOptions& options);

}  // namespace touchable
