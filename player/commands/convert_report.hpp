#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "player/commands/convert_command.hpp"
#include "player/commands/plane_loss.hpp"
#include "player/run/force_comparison.hpp"

namespace touchable {

/// What was done, for a person.
struct Converted {
    std::vector<std::string> notes;  ///< what is told of the clip that was read
    Scene scene;                     ///< of what was written
    std::vector<TrackInfo> tracks;   ///< that it has
    std::int64_t frames = 0;
    PlaneLosses losses;
    std::string sound;                      ///< what became of it; empty: there is none
    std::optional<ForceComparison> forces;  ///< where values of what is touched were lost
};

std::string report_to_text(const ConvertOptions& options, const Converted& done);

}  // namespace touchable
