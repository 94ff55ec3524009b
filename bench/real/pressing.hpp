#pragma once

#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Angles between forces and the normals of the pressed planes.
class PressErrors {
public:
    /// Presses a finger on each plane: from 2 mm above it straight in to 3 mm under it, then 4 pixels to the
    /// right and 2 down, passing under the plane's middle. Every tick of this last path counts.
    Result<void> press(const Scene& scene, const SurfaceFrame& frame, const std::vector<DepthPlane>& planes);
    /// Appends presses, force_angle_deg_rms, _median and _p95 of the ticks in contact, contact_lost_pct for
    /// the others.
    void report(Figures& figures) const;
    /// 180 without any contact.
    double angle_deg_rms() const;

private:
    std::vector<double> angles_;
    std::size_t fingers_ = 0, lost_ = 0;
};

}  // namespace touchable
