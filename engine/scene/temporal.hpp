#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/scene/scene.hpp"

namespace touchable {

/// How far from one frame to the next a code may be off by noise alone. In codes the noise of every coding is
/// a polynomial of second degree in the code's distance from one end, with coefficients that are not
/// negative: of inverse depth w it is constant w^2 + quadratic.
struct TemporalGate {
    std::uint16_t constant = 0, linear = 0, quadratic = 0;  ///< each at most a third of 65535
    std::uint16_t last = 0;                                 ///< largest code
    int shift = 0;                                          ///< by which a distance fills 16 bits
    bool from_last = false;                                 ///< distances are taken from `last`, not from 0

    /// At most temporal_most_gate.
    int at(std::uint16_t code) const;
    bool operator==(const TemporalGate&) const = default;
};
/// So twice a gate has 16 bits.
inline constexpr int temporal_most_gate = 32767;
/// Frames for which a pixel without depth keeps what it had.
inline constexpr int temporal_hold_frames = 3;

/// The temporal filter, as it works on one scene's codes; docs/conventions.md has the arithmetic.
struct TemporalFilter {
    int factor = 1;  ///< by which codes are multiplied first, so that a mean has somewhere to lie
    TemporalGate gate;
    DepthCoding coding;  ///< of the finer codes; where nothing changed the depth is the same double
    bool operator==(const TemporalFilter&) const = default;
};

/// What the scene asks for; nothing: no filter. Needs a scene that `validate` accepts.
std::optional<TemporalFilter> temporal_filter(const Scene& scene);

}  // namespace touchable
