#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "engine/content/gradient_noise.hpp"

namespace touchable {

/// What lies at one place of the procedural planet.
struct Ground {
    double elevation;  ///< over the sea: about -1 to 1, land where positive
    double relief;     ///< 0 (sea, coast) to 1 (highest mountain)
    double moisture;   ///< 0 (desert) to 1 (forest)
    double ice;        ///< 0 to 1: polar and mountain snow, sea ice
};

/// A deterministic planet that looks like one and is none: continents, mountains and climate from seeded
/// noise. 38 % of it is land.
class Planet {
public:
    explicit Planet(std::uint64_t seed);
    /// `place`: unit vector in the planet's own frame, +Y its north pole.
    Ground ground(const glm::dvec3& place) const;

private:
    double continents(const glm::dvec3& place) const;

    GradientNoise noise_;
    double sea_level_;
};

}  // namespace touchable
