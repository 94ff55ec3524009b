// A planet of seeded noise, and the light on it.
#include "engine/content/planet.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

namespace touchable {
namespace {

constexpr double land_share = 0.38;

/// Places spread evenly enough over the sphere, without an angle: grid points of a cube's shell, projected to
/// the sphere and weighted by the area that each stands for.
struct Place {
    glm::dvec3 at;
    double area;
};
std::vector<Place> survey() {
    constexpr int side = 24;
    std::vector<Place> places;
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const double a = (2 * i + 1.0) / side - 1, b = (2 * j + 1.0) / side - 1;
                const double c = face < 3 ? 1 : -1, length = std::sqrt(a * a + b * b + 1);
                const glm::dvec3 on_cube = face % 3 == 0   ? glm::dvec3(c, a, b)
                                           : face % 3 == 1 ? glm::dvec3(a, c, b)
                                                           : glm::dvec3(a, b, c);
                places.push_back({on_cube / length, 1 / (length * length * length)});
            }
    return places;
}

constexpr glm::dvec3 air_colour{0.16, 0.36, 0.75};

glm::dvec3 sea_colour(const Ground& ground) {
    const glm::dvec3 abyss{0.004, 0.017, 0.060}, deep{0.008, 0.042, 0.125}, shelf{0.025, 0.170, 0.235};
    const double depth = -ground.elevation;
    const glm::dvec3 open = glm::mix(deep, abyss, smooth_step(0.10, 0.60, depth));
    return glm::mix(shelf, open, smooth_step(0.0, 0.10, depth));
}

glm::dvec3 land_colour(const Ground& ground) {
    const glm::dvec3 forest{0.030, 0.085, 0.022}, steppe{0.150, 0.150, 0.045}, desert{0.430, 0.285, 0.130};
    const glm::dvec3 rock{0.170, 0.125, 0.090}, beach{0.380, 0.310, 0.190};
    const glm::dvec3 dry = glm::mix(desert, steppe, smooth_step(0.22, 0.48, ground.moisture));
    glm::dvec3 colour = glm::mix(dry, forest, smooth_step(0.42, 0.68, ground.moisture));
    colour = glm::mix(colour, rock, smooth_step(0.28, 0.55, ground.relief));
    return glm::mix(beach, colour, smooth_step(0.0, 0.018, ground.elevation));
}

}  // namespace

Planet::Planet(std::uint64_t seed) : noise_(seed), sea_level_(0) {
    struct Height {
        double height, area;
    };
    std::vector<Height> heights;
    double whole = 0, under = 0;
    for (const Place& place : survey()) {
        heights.push_back({continents(place.at), place.area});
        whole += place.area;
    }
    std::ranges::stable_sort(heights, {}, &Height::height);
    for (const Height& height : heights) {
        sea_level_ = height.height;
        under += height.area;
        if (under >= (1 - land_share) * whole) break;
    }
}

/// Octaves bent by slower ones: coasts that wander, with gulfs and islands.
double Planet::continents(const glm::dvec3& place) const {
    const glm::dvec3 p = 1.15 * place;
    const glm::dvec3 bend{noise_.octaves(2.0 * p + glm::dvec3(3.1, 0.7, 9.2), 2),
                          noise_.octaves(2.0 * p + glm::dvec3(8.3, 2.8, 1.4), 2),
                          noise_.octaves(2.0 * p + glm::dvec3(1.9, 6.5, 4.6), 2)};
    return noise_.octaves(p + 0.16 * bend, 7) +
           0.10 * noise_.octaves(9.0 * place + glm::dvec3(4.4, 1.3, 8.8), 4);
}

Ground Planet::ground(const glm::dvec3& place) const {
    Ground ground{};
    ground.elevation = continents(place) - sea_level_;
    const double inland = smooth_step(0.0, 0.16, ground.elevation);
    if (ground.elevation > 0) {
        const double ranges = noise_.ridges(3.4 * place + glm::dvec3(11.2, 4.1, 7.7), 6);
        const double where = smooth_step(-0.25, 0.30, noise_.at(1.7 * place + glm::dvec3(5.5, 12.5, 2.2)));
        ground.relief = std::clamp(inland * (0.10 + 1.25 * ranges * (0.20 + 0.80 * where)), 0.0, 1.0);
    }
    const double wobble = noise_.octaves(3.1 * place + glm::dvec3(21.4, 9.9, 13.3), 3);
    const double latitude = std::fabs(place.y);  // its sine
    // Wet at the equator, dry at the tropics, wet again at middle latitudes.
    const double belt = smooth_step(0.10, 0.36, latitude) * (1 - smooth_step(0.50, 0.72, latitude));
    ground.moisture = std::clamp(0.80 - 0.55 * belt + 0.70 * wobble - 0.12 * inland, 0.0, 1.0);
    const double cold = latitude + 0.07 * wobble + 0.42 * ground.relief;
    ground.ice = ground.elevation > 0 ? smooth_step(0.87, 0.95, cold) : smooth_step(0.93, 0.955, cold);
    return ground;
}

glm::dvec3 planet_colour(const Ground& ground, const glm::dvec3& normal, const glm::dvec3& to_eye,
                         double slope) {
    const glm::dvec3 snow{0.80, 0.84, 0.88};
    const glm::dvec3 bare = ground.elevation > 0 ? land_colour(ground) : sea_colour(ground);
    return in_daylight(glm::mix(bare, snow, ground.ice), normal, to_eye, std::clamp(1 + slope, 0.35, 1.9));
}

glm::dvec3 in_daylight(const glm::dvec3& ground, const glm::dvec3& normal, const glm::dvec3& to_eye,
                       double relief_light) {
    // A soft terminator: light reaches a little past the edge of the day.
    const double facing = glm::dot(normal, sunward), day = smooth_step(-0.12, 0.30, facing);
    const double light = 0.012 + 1.55 * day * (0.18 + 0.82 * std::max(0.0, facing)) * relief_light;
    const glm::dvec3 colour = light * ground;

    // The line of sight passes through more air toward the limb.
    const double grazing = 1 - std::max(0.0, glm::dot(normal, to_eye));
    const double air = day * (0.05 + 0.75 * grazing * grazing * grazing);
    return glm::mix(colour, air_colour * (0.35 + 0.65 * std::max(0.0, facing)), std::min(1.0, air));
}

glm::dvec3 sky_colour(int column, int row, int picture_width, const glm::dvec3& outward, double altitude) {
    const int grain = std::max(1, picture_width / 720);  // a star's side in pixels
    SplitMix64 random(
        mix64(static_cast<std::uint64_t>(column / grain) << 32 | static_cast<std::uint64_t>(row / grain)));
    glm::dvec3 colour{0.0012, 0.0016, 0.0040};
    if (random.unit() < 0.0025) {
        const double strength = random.unit(), warmth = random.unit();
        colour +=
            0.30 * strength * strength * strength * glm::dvec3(0.8 + 0.2 * warmth, 0.9, 1.0 - 0.2 * warmth);
    }
    const double thickness = 0.030, thin = 1 / (1 + altitude / thickness);
    const double glow = thin * thin * thin * smooth_step(-0.35, 0.75, glm::dot(outward, sunward));
    return colour + 0.75 * glow * air_colour;
}

std::array<std::uint8_t, 3> to_bytes(const glm::dvec3& colour) {
    std::array<std::uint8_t, 3> bytes{};
    for (int channel = 0; channel < 3; ++channel)
        bytes[static_cast<std::size_t>(channel)] = static_cast<std::uint8_t>(
            std::floor(255 * std::sqrt(std::clamp(colour[channel], 0.0, 1.0)) + 0.5));
    return bytes;
}

}  // namespace touchable
