#include "engine/scene/lens.hpp"

namespace touchable {
namespace {

double radial(const std::array<double, 8>& terms, double r2) {
    const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = terms;
    return (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
}

}  // namespace

LensPoint LensDistortion::distorted(LensPoint point) const {
    const double x = point.x, y = point.y, r2 = x * x + y * y, stretch = radial(terms, r2);
    const double p1 = terms[2], p2 = terms[3];
    return {x * stretch + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * stretch + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

double LensDistortion::reach() const {
    constexpr double farthest = 10, step = 0.005;
    double before = 0;
    for (double r = step; r < farthest; r += step) {
        const double shown = r * radial(terms, r * r);
        if (!(shown > before)) return r - step;
        before = shown;
    }
    return farthest;
}

}  // namespace touchable
