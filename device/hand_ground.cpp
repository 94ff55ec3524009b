// The surface under a hand: its nearest point, its relief, and goals that do not fit it.
#include <algorithm>
#include <cmath>

#include "device/hand_parts.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// Limits of smooth, rough and broken ground.
constexpr int relief_rings = 4;
constexpr double least_cliff = 0.006;  // device metres: a lower step up is rough ground, however steep
// Rise per length, as the camera sees it: 65 degrees. Usual friction (0.4) holds a proxy at a wall of 68.
constexpr double steepest = 2.14;

/// Finds the nearest surface among the pixels at Chebyshev distance `radius` from the start, in the box.
class RingSearch {
public:
    RingSearch(const SurfaceProbe& probe, const glm::dvec2& from, const HandArea& box)
        : probe_(probe), from_(from), box_(box) {}

    std::optional<SurfacePoint> ring(int radius) {
        best_.reset();
        const double r = radius;
        // Rows above and below, then the columns between them, clipped to the box.
        const double x0 = std::max(-r, std::ceil(box_.least.x - from_.x));
        const double x1 = std::min(r, std::floor(box_.greatest.x - from_.x));
        for (double x = x0; x <= x1; ++x) {
            look({x, -r});
            if (radius > 0) look({x, r});
        }
        const double y0 = std::max(-r + 1, std::ceil(box_.least.y - from_.y));
        const double y1 = std::min(r - 1, std::floor(box_.greatest.y - from_.y));
        for (double y = y0; y <= y1; ++y) {
            look({-r, y});
            look({r, y});
        }
        return best_;
    }

private:
    void look(const glm::dvec2& step) {
        const double distance2 = step.x * step.x + step.y * step.y;
        if (best_ && distance2 >= best_distance2_) return;
        const glm::dvec2 pixel = from_ + step;
        if (!box_.contains(pixel)) return;
        if (const std::optional<double> depth = probe_.depth_under(pixel.x, pixel.y)) {
            best_ = SurfacePoint{pixel, *depth};
            best_distance2_ = distance2;
        }
    }

    const SurfaceProbe& probe_;
    glm::dvec2 from_;
    HandArea box_;
    std::optional<SurfacePoint> best_;
    double best_distance2_ = 0;
};

}  // namespace

HandArea middle_of(const SurfaceProbe& probe, double fraction) {
    const glm::dvec2 last(probe.width() - 1, probe.height() - 1);
    return {last * (0.5 - 0.5 * fraction), last * (0.5 + 0.5 * fraction)};
}

std::optional<SurfacePoint> nearest_surface(const SurfaceProbe& probe, const glm::dvec2& pixel,
                                            const HandArea& box) {
    RingSearch search(probe, pixel, box);
    const int rings = std::max(probe.width(), probe.height());
    for (int radius = 0; radius <= rings; ++radius) {
        if (const std::optional<SurfacePoint> found = search.ring(radius)) return found;
    }
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

LocalRelief LocalReliefSearch::about(const glm::dvec2& pixel, double depth, const SurfaceProbe& probe) const {
    const glm::dvec2 size = pixel_size(probe, pixel, depth, metres_per_scene_unit_);
    bool broken = false, rough = false;
    double highest = depth;
    for (int ring = 1; ring <= relief_rings; ++ring) {
        const double radius = reach_ * ring / relief_rings;
        for (std::size_t k = 0; k < directions; ++k) {
            const glm::dvec2 place = pixel + radius * directions_[k] / size;
            if (!box_.contains(place)) continue;
            const std::optional<double> there = probe.depth_under(place.x, place.y);
            const double rise = there ? (depth - *there) * metres_per_scene_unit_ : 0;  // towards the camera
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
        // Written so that NaN is outside.
        if (!(goal.z < 0)) {
            ++outside_;
            continue;
        }
        const glm::dvec3 seen = probe.project(goal);
        const bool inside =
            seen.x >= 0 && seen.x <= probe.width() - 1 && seen.y >= 0 && seen.y <= probe.height() - 1;
        if (!inside) {
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
