#pragma once

#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Angles between what fingers feel and the normals of the planes they press.
class PressErrors {
public:
    /// A finger on each plane: from 2 mm above it straight in to 3 mm under it, then 4 pixels to the right
    /// and 2 down, under the plane's middle on the way. Every tick of that way counts.
    Result<void> press(const Scene& scene, const SurfaceFrame& frame, const std::vector<DepthPlane>& planes);
    /// presses, force_angle_deg_rms, _median and _p95 of the ticks in contact, contact_lost_pct of the
    /// others.
    void report(Figures& figures) const;
    /// 180 where nothing was felt.
    double angle_deg_rms() const;

private:
    std::vector<double> angles_;
    std::size_t fingers_ = 0, lost_ = 0;
};

}  // namespace touchable
