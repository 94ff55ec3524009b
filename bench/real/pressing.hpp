#pragma once

#include <limits>
#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// How wrong a force was, and what the frame showed of that.
struct BarPlace {
    ErrorSigns::Squares signs;
    ErrorBar bar;
    double degrees = 0;  ///< of its direction
    double depth = 0;    ///< of its size, as a way into the surface, scene units
};
/// Presses 3 mm straight into each plane; `frame` is built with_error_bars. Where there is no contact, there
/// is no BarPlace.
Result<void> press_barred(const Scene& scene, const SurfaceFrame& frame,
                          const std::vector<DepthPlane>& planes, std::vector<BarPlace>& places);

/// Angles between forces and the normals of the pressed planes.
class PressErrors {
public:
    /// `trusted_to`: depth beyond which force is said not to be trusted, of the scenes that are pressed.
    explicit PressErrors(double trusted_to = std::numeric_limits<double>::infinity())
        : trusted_to_(trusted_to) {}
    /// Presses a finger on each plane: from 2 mm above it straight in to 3 mm under it, then 4 pixels to the
    /// right and 2 down, passing under the plane's middle. Every tick of this last path counts.
    Result<void> press(const Scene& scene, const SurfaceFrame& frame, const std::vector<DepthPlane>& planes);
    /// Appends presses, force_angle_deg_rms, _median and _p95 of the ticks in contact, contact_lost_pct for
    /// the others; over_20deg_pct, untrusted_pct and trusted_over_20deg_pct.
    void report(Figures& figures) const;
    /// 180 without any contact.
    double angle_deg_rms() const;
    /// Share of the ticks in contact that are beyond `trusted_to`, and of the nearer ones that are wrong.
    double untrusted_pct() const;
    double trusted_over_20deg_pct() const;

private:
    double trusted_to_;
    std::vector<double> angles_, trusted_;
    std::size_t fingers_ = 0, lost_ = 0;
};

}  // namespace touchable
