#pragma once

// The procedural planet: its ground, and how that looks. Colours are linear light, 0 to 1; only the picture,
// never the touch, depends on them.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "engine/content/seeded_noise.hpp"

namespace touchable {

/// The ground at one place of the procedural planet.
struct Ground {
    double elevation;  ///< over the sea: about -1 to 1, land where positive
    double relief;     ///< 0 (sea, coast) to 1 (highest mountain)
    double moisture;   ///< 0 (desert) to 1 (forest)
    double ice;        ///< 0 to 1: polar and mountain snow, sea ice
};

/// A deterministic imaginary planet: continents, mountains and climate from seeded noise. 38 % of it is land.
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

/// Towards the sun: a unit vector in the world.
inline constexpr glm::dvec3 sunward{-0.56, 0.42, 0.7141428428542850};

/// Colour in the day of a place whose ground has this colour. `normal` is the unit vector up, `to_eye` one
/// toward the eye; `relief_light` is the ground's brightness relative to level ground.
glm::dvec3 in_daylight(const glm::dvec3& ground, const glm::dvec3& normal, const glm::dvec3& to_eye,
                       double relief_light);

/// Colour of a place of the procedural planet. `normal` and `to_eye` are unit vectors; `slope` is how much
/// the ground rises toward the sun (relief per radius of the planet; 0: level).
glm::dvec3 planet_colour(const Ground& ground, const glm::dvec3& normal, const glm::dvec3& to_eye,
                         double slope);

/// Colour beside the planet: night, faint stars, and a glow on the lit side of the limb. `outward` is the
/// unit vector from the planet's centre to the nearest point of the line of sight, `altitude` that point's
/// distance from the limb in radii, at least 0.
glm::dvec3 sky_colour(int column, int row, int picture_width, const glm::dvec3& outward, double altitude);

/// Linear light as the bytes of a picture, gamma 2.
std::array<std::uint8_t, 3> to_bytes(const glm::dvec3& colour);

}  // namespace touchable
