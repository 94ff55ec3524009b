#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "engine/clip/plane_role.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What values of one plane became: of each pixel as it was, and the nearest one that there is now.
struct PlaneLoss {
    std::int64_t samples = 0, changed = 0;
    int largest = 0;     ///< of a stored value
    double squares = 0;  ///< of them, summed up
    // Of depth.
    bool is_recoded = false;                        ///< values mean something else now: depths are compared
    std::int64_t pixels = 0;                        ///< that have a depth in both
    double largest_metres = 0, squares_metres = 0;  ///< of these
    std::int64_t appeared = 0, disappeared = 0;     ///< pixels that have a depth, and had none; and had one

    double rms() const { return samples > 0 ? std::sqrt(squares / static_cast<double>(samples)) : 0; }
    double rms_metres() const {
        return pixels > 0 ? std::sqrt(squares_metres / static_cast<double>(pixels)) : 0;
    }
};

/// By PlaneRole.
using PlaneLosses = std::array<PlaneLoss, all_roles.size()>;

/// Adds what became of a frame of the scene `before` in one of the scene `now`, whose values mean the same;
/// sizes may differ.
void add_loss(const RawFrame& before, const RawFrame& now, const Scene& scene, PlaneLosses& losses);

/// The same of depth alone, whose values mean something else in each of both scenes (of one unit): what
/// changes is a depth.
void add_recoded_loss(const RawFrame& before, const Scene& scene, const RawFrame& now, const Scene& recoded,
                      PlaneLosses& losses);

}  // namespace touchable
