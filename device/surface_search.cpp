#include "device/surface_search.hpp"

#include <algorithm>
#include <cmath>

namespace touchable {
namespace {

/// Visits the pixels at Chebyshev distance `ring` from the start, as far as they lie in the box.
class RingSearch {
public:
    RingSearch(const SurfaceProbe& probe, const glm::dvec2& from, const PixelBox& box)
        : probe_(probe), from_(from), box_(box) {}

    std::optional<SurfacePoint> ring(int radius) {
        best_.reset();
        const double r = radius;
        // Rows above and below, then the columns between them; what lies outside the box is never walked.
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
    PixelBox box_;
    std::optional<SurfacePoint> best_;
    double best_distance2_ = 0;
};

}  // namespace

PixelBox middle_of(const SurfaceProbe& probe, double fraction) {
    const glm::dvec2 last(probe.width() - 1, probe.height() - 1);
    return {last * (0.5 - 0.5 * fraction), last * (0.5 + 0.5 * fraction)};
}

std::optional<SurfacePoint> nearest_surface(const SurfaceProbe& probe, const glm::dvec2& pixel,
                                            const PixelBox& box) {
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

}  // namespace touchable
