#pragma once

#include <cstdint>

namespace touchable {

/// What became of the framesets of a live stream, and how it was.
struct StreamFigures {
    std::int64_t whole = 0;     ///< received with all planes that are felt
    std::int64_t held = 0;      ///< in place of which the one before was felt on: those below
    std::int64_t late = 0;      ///< whole only once a later one had been shown
    std::int64_t lost = 0;      ///< never whole
    std::int64_t torn = 0;      ///< damaged
    std::int64_t repeated = 0;  ///< pictures that came twice
    std::int64_t connections = 0;
    double delay_ms = 0;        ///< that framesets wait for others' sake, now
    double longest_gap_ms = 0;  ///< between two that were whole
};

}  // namespace touchable
