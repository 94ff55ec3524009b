#pragma once

#include <array>

namespace touchable {

/// A place in the plane at distance 1 of a camera: x to the right, y down.
struct LensPoint {
    double x, y;
};

/// How a lens bends what a pinhole would see, after Brown and Conrady, in OpenCV's terms and order: k1, k2,
/// p1, p2, k3, k4, k5, k6. All 0: not at all.
struct LensDistortion {
    std::array<double, 8> terms{};

    bool any() const { return *this != LensDistortion{}; }
    /// Where the lens shows what a pinhole shows at `point`.
    LensPoint distorted(LensPoint point) const;
    /// So far from the axis distances grow with those of a pinhole. What is farther off would be shown on top
    /// of what is nearer: no lens does that, the terms only say nothing of it. At most 10.
    double reach() const;
    bool operator==(const LensDistortion&) const = default;
};

}  // namespace touchable
