#pragma once

#include <cstdint>
#include <string>

#include "tests/stress/suites.hpp"

namespace touchable::stress {

/// What a run met with and what was measured; sums of several runs are sums and maxima.
struct Coverage {
    std::int64_t ticks = 0, finger_ticks = 0;
    std::int64_t contact = 0;                                       ///< finger-ticks
    std::int64_t with_heights = 0, with_friction = 0, sliding = 0;  ///< of those in contact
    std::int64_t at_invalid = 0;                ///< of those certified: a corner of the place is no depth
    std::int64_t in_holes = 0;                  ///< of those certified: stiffness is that of holes, in part
    std::int64_t landings = 0, departures = 0;  ///< contact made, contact lost
    std::int64_t frame_changes = 0, between_frames = 0;  ///< ticks
    std::int64_t held_goals = 0, refusals = 0;
    std::int64_t capped = 0, most_events = 0;
    std::int64_t certified = 0, compared = 0, other_basins = 0;
    double worst_behind = 0;                      ///< relative, of 1 / planar depth
    double worst_excess = 0;                      ///< of |P - G| over the minimum, over 1 + |P - G|
    double worst_way = 0;                         ///< scene units left to go, over 1 + |P - G|
    double worst_ratio = 0;                       ///< |P - G| over the reference's, same basin
    double worst_angle = 0;                       ///< degrees, same basin
    double energy_created = 0, energy_bound = 0;  ///< J, the most of any finger

    void add(const Coverage& other);
    double contact_share() const;
    /// What is missing for a test of anything; empty where nothing is.
    std::string missing(const Needs& needs) const;
    std::string in_words() const;  ///< one line
};

}  // namespace touchable::stress
