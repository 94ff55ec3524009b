#pragma once

#include <algorithm>
#include <optional>

#include "engine/scene/code_curve.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Pixels that hang in the air between two surfaces, because they saw some of both, are pulled to one of
/// them; docs/conventions.md has the rule.
struct FlyingPixels {
    CodeCurve gate;  ///< codes that differ by no more belong to one surface

    int gate_at(std::uint16_t code) const { return std::max(gate.at(code), 1); }
    bool operator==(const FlyingPixels&) const = default;
};

/// Steps of the widest ramp from one surface to another whose pixels are pulled in: edges of depth that was
/// made larger, as phones store it.
inline constexpr int widest_ramp = 12;
/// Pixels along a line that a code is judged by, to each side of it.
inline constexpr int flying_reach = widest_ramp;

/// What the scene asks for; nothing: no filter. Needs a scene that `validate` accepts.
std::optional<FlyingPixels> flying_pixels(const Scene& scene);

}  // namespace touchable
