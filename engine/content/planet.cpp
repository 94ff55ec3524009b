#include "engine/content/planet.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/content/smooth.hpp"

namespace touchable {
namespace {

constexpr double land_share = 0.38;

/// Places spread evenly enough over the sphere, without an angle: grid points of a cube's shell, drawn to the
/// sphere and counted by the area each stands for.
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
    std::stable_sort(heights.begin(), heights.end(),
                     [](const Height& a, const Height& b) { return a.height < b.height; });
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

}  // namespace touchable
