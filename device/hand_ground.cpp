// SPDX-License-Identifier: Apache-2.0
// The surface under a hand: its nearest point, its relief, and goals that do not fit it.
#include <algorithm>
#include <array>
#include <cmath>

#include "device/hand_parts.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// Limits of smooth, rough and broken ground.
constexpr int relief_rings = 4, relief_directions = 12;
constexpr double least_cliff = 0.006;  // device metres: a lower step up is rough ground, however steep
// Rise per length, as the camera sees it: 65 degrees. Usual friction (0.4) holds a proxy at a wall of 68.
constexpr double steepest = 2.14;

/// In all directions, x right, y down.
const auto unit_vectors = [] {
    std::array<glm::dvec2, relief_directions> all;
    for (int k = 0; k < relief_directions; ++k) {
        const double angle = 2 * pi * k / relief_directions;
        all[static_cast<std::size_t>(k)] = {cosine(angle), -sine(angle)};
    }
    return all;
}();

/// The nearest surface among the pixels at Chebyshev distance `r` from the start, in the box.
std::optional<SurfacePoint> surface_on_ring(const SurfaceProbe& probe, const glm::dvec2& from,
                                            const HandArea& box, double r) {
    std::optional<SurfacePoint> best;
    double best_distance2 = 0;
    const auto look = [&](const glm::dvec2& step) {
        const double distance2 = step.x * step.x + step.y * step.y;
        if (best && distance2 >= best_distance2) return;
        const glm::dvec2 pixel = from + step;
        if (!box.contains(pixel)) return;
        if (const std::optional<double> depth = probe.depth_under(pixel.x, pixel.y)) {
            best = SurfacePoint{pixel, *depth};
            best_distance2 = distance2;
        }
    };
    // Rows above and below, then the columns between them, clipped to the box: all rings together cost as
    // many looks as the box has pixels, also in a picture of one row.
    const auto meets = [r](double from, double least, double greatest) {
        return from - r >= least || from + r <= greatest;
    };
    const double x0 = std::max(-r, std::ceil(box.least.x - from.x));
    const double x1 = std::min(r, std::floor(box.greatest.x - from.x));
    if (meets(from.y, box.least.y, box.greatest.y))
        for (double x = x0; x <= x1; ++x)
            for (const double y : {-r, r}) look({x, y});
    const double y0 = std::max(-r + 1, std::ceil(box.least.y - from.y));
    const double y1 = std::min(r - 1, std::floor(box.greatest.y - from.y));
    if (meets(from.x, box.least.x, box.greatest.x))
        for (double y = y0; y <= y1; ++y)
            for (const double x : {-r, r}) look({x, y});
    return best;
}

}  // namespace

HandArea middle_of(const SurfaceProbe& probe, double fraction) {
    const glm::dvec2 last(probe.width() - 1, probe.height() - 1);
    return {last * (0.5 - 0.5 * fraction), last * (0.5 + 0.5 * fraction)};
}

std::optional<SurfacePoint> nearest_surface(const SurfaceProbe& probe, const glm::dvec2& pixel,
                                            const HandArea& box) {
    const int rings = std::max(probe.width(), probe.height());
    for (int radius = 0; radius <= rings && !stop_requested(); ++radius)
        if (const auto found = surface_on_ring(probe, pixel, box, radius)) return found;
    return std::nullopt;
}

double device_depth(const Workspace& workspace) {
    return workspace.origin.z < 0 ? -workspace.origin.z : 0.16 / workspace.metres_per_scene_unit;
}

double start_depth(const SurfaceProbe& probe, const glm::dvec2& pixel, const HandArea& box,
                   const Workspace& workspace) {
    const std::optional<SurfacePoint> found = nearest_surface(probe, pixel, box);
    return found ? found->depth : device_depth(workspace);
}

LocalRelief local_relief(const SurfaceProbe& probe, const glm::dvec2& pixel, double depth, double reach,
                         double metres_per_scene_unit, const HandArea& box) {
    const glm::dvec2 size = pixel_size(probe, pixel, depth, metres_per_scene_unit);
    bool broken = false, rough = false;
    double highest = depth;
    for (int ring = 1; ring <= relief_rings; ++ring) {
        const double radius = reach * ring / relief_rings;
        for (const glm::dvec2& direction : unit_vectors) {
            const glm::dvec2 place = pixel + radius * direction / size;
            if (!box.contains(place)) continue;
            const std::optional<double> there = probe.depth_under(place.x, place.y);
            const double rise = there ? (depth - *there) * metres_per_scene_unit : 0;  // towards the camera
            broken = broken || !there || std::fabs(rise) > std::max(least_cliff, steepest * radius);
            rough = rough || rise > steepest * radius;
            highest = std::min(highest, there.value_or(depth));
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

void GoalWatch::look(const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    for (glm::dvec3& goal : goals) {
        ++goals_;
        const glm::dvec3 seen = goal.z < 0 ? probe.project(goal) : glm::dvec3(-1);
        // Written so that NaN is outside.
        if (!middle_of(probe, 1).contains(glm::dvec2(seen))) {
            ++outside_;
            continue;
        }
        const auto surface = probe.depth_under(seen.x, seen.y);
        if (!surface) continue;
        const double below = (seen.z - *surface) * metres_per_scene_unit_;
        far_below_ += below > far_below;
        if (deepest_ && below > *deepest_)
            goal = probe.unproject(seen.x, seen.y, *surface + *deepest_ / metres_per_scene_unit_);
    }
}

std::vector<std::string> GoalWatch::remarks() const {
    std::vector<std::string> out;
    const auto say = [&](std::int64_t some, const std::string& what) {
        const double percent =
            goals_ > 0 ? 100.0 * static_cast<double>(some) / static_cast<double>(goals_) : 0;
        if (percent < 1) return;
        out.push_back(formatted("%.1f %% of the goals ", percent) + what);
    };
    say(outside_, "lie outside the picture, where there is only the wall around it");
    say(far_below_,
        deepest_ ? "were more than 10 mm below the surface, and were raised"
                 : "lie more than 10 mm below the surface; depth=MM among the hand's keys raises them");
    return out;
}

}  // namespace touchable
