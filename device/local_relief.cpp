#include "device/local_relief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

constexpr int rings = 4;
constexpr double least_cliff = 0.006;  // device metres: a lower step is rough ground, however steep
constexpr double steepest = 2.14;      // rise per length, as the camera sees it: 65 degrees
constexpr double least_bend = 0.0001;  // device metres: by which rough ground leaves the straight ...
constexpr double sharpest = 1.0 / 6;   // ... or, per length, if that is more: 9.5 degrees

}  // namespace

LocalReliefSearch::LocalReliefSearch(double reach, double metres_per_scene_unit, const PixelBox& box)
    : reach_(reach), metres_per_scene_unit_(metres_per_scene_unit), box_(box) {
    for (int k = 0; k < directions; ++k) {
        const double angle = 2 * pi * k / directions;
        directions_[static_cast<std::size_t>(k)] = {cosine(angle), -sine(angle)};
    }
}

LocalRelief LocalReliefSearch::about(const glm::dvec2& pixel, double depth, const SurfaceProbe& probe) const {
    const glm::dvec2 size = pixel_size(probe, pixel, depth, metres_per_scene_unit_);
    bool broken = false, rough = false;
    double highest = depth;
    for (int ring = 1; ring <= rings; ++ring) {
        const double radius = reach_ * ring / rings;
        std::array<double, directions> rise;  // towards the camera, device metres; where it was looked at
        rise.fill(std::numeric_limits<double>::quiet_NaN());
        for (std::size_t k = 0; k < directions; ++k) {
            const glm::dvec2 place = pixel + radius * directions_[k] / size;
            if (!box_.contains(place)) continue;
            const std::optional<double> there = probe.depth_under(place.x, place.y);
            if (there) rise[k] = (depth - *there) * metres_per_scene_unit_;
            broken = broken || !there || std::fabs(rise[k]) > std::max(least_cliff, steepest * radius);
            highest = std::min(highest, there.value_or(depth));
        }
        // A slope that rises to one side falls to the other; at a bend a sum is left.
        for (std::size_t k = 0; k < directions / 2; ++k) {
            rough = rough ||
                    std::fabs(rise[k] + rise[k + directions / 2]) > std::max(least_bend, sharpest * radius);
        }
    }
    return {broken  ? LocalRelief::Kind::broken
            : rough ? LocalRelief::Kind::rough
                    : LocalRelief::Kind::smooth,
            highest};
}

glm::dvec2 pixel_size(const SurfaceProbe& probe, const glm::dvec2& pixel, double depth,
                      double metres_per_scene_unit) {
    const glm::dvec3 here = probe.unproject(pixel.x, pixel.y, depth);
    const glm::dvec3 right = probe.unproject(pixel.x + 1, pixel.y, depth);
    const glm::dvec3 below = probe.unproject(pixel.x, pixel.y + 1, depth);
    return glm::dvec2(right.x - here.x, here.y - below.y) * metres_per_scene_unit;
}

}  // namespace touchable
