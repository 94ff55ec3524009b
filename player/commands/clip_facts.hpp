#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/scene.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// How steep one step of the depth staircase feels: depth step of one code / width of one pixel, at that
/// depth.
struct Kappa {
    double depth = 0;  ///< scene units
    double kappa = 0;
};

/// All that `info` says of a clip.
struct ClipFacts {
    std::string clip;
    Scene scene;                          ///< as it is touched
    std::optional<ChosenFilters> chosen;  ///< nothing: all filters are stated
    std::vector<TrackInfo> tracks;
    std::optional<std::int64_t> frames;
    std::vector<std::string> notes;
    std::string unit_doubt;  ///< one of the notes; empty: the unit may be right
    double fov_x_degrees = 0, fov_y_degrees = 0;
    double invalid_pct = 0;  ///< of the first frame's stored values
    double nearest = 0,
           farthest = 0;  ///< valid depths of the first frame, scene units; both 0: none is valid
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel of the first frames is valid
    Kappa near, mid, far;  ///< at the near plane (metric without one: at `nearest`), between, at far

    bool has_track(const std::string& role) const;
};

/// Reads the description and the first frames; both can fail.
Result<ClipFacts> clip_facts(const ClipChoice& choice);

}  // namespace touchable
