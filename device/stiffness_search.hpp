#pragma once

#include <functional>
#include <string>

#include "device/device_watch.hpp"

namespace touchable {

/// Up to which stiffness a spring about the place of rest stays quiet, with no hand on the handle.
struct StiffnessFinding {
    double quiet = 0;       ///< N/m, the largest that was quiet; 0: none was
    double shaking = 0;     ///< N/m, the least that was not; 0: all were quiet, up to the device's limit
    std::string why{};      ///< what that one did
    bool moved = true;      ///< false: friction held the handle against every nudge, which says nothing
    double most_force = 0;  ///< N, that was exerted at most
};

/// Why it is here: the largest stiffness that stays quiet depends on the delays of this computer and on this
/// very device, so no table of limits has it. A person with a new device gets a safe --max-stiffness before a
/// hand is on the handle.
///
/// Climbs in steps of a factor of sqrt(2), from soft to the device's own limit, with 1.5 N or half of the
/// device's longest force at most; force ends at the first sign of growth, and with the search however it
/// ends. `tries` is told of each stiffness (N/m). Refuses (ErrorKind::usage) a device that exerts no force;
/// other errors are those of SpringTrial.
Result<StiffnessFinding> find_stiffness(HapticDevice& device, const TickPace& pace,
                                        const std::function<void(double)>& tries = {});

}  // namespace touchable
