// SPDX-License-Identifier: Apache-2.0
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
    double degrees = 0;  ///< of its direction
    double depth = 0;    ///< of its size, as a way into the surface, scene units
};

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
    /// the others; over_20deg_pct, untrusted_pct and trusted_over_20deg_pct; if frames were built
    /// with_error_bars, the ticks in their bars (bars_hold_pct), and bar_deg_median.
    void report(Figures& figures) const;
    /// 180 without any contact.
    double angle_deg_rms() const;
    /// Share of the ticks in contact that are beyond `trusted_to`, and of the nearer ones that are wrong.
    double untrusted_pct() const;
    double trusted_over_20deg_pct() const;
    /// 3 mm straight in, of frames built with_error_bars; without contact there is none.
    const std::vector<BarPlace>& places() const { return places_; }

private:
    double trusted_to_;
    std::vector<double> angles_, trusted_, bars_;
    std::vector<BarPlace> places_;
    std::size_t fingers_ = 0, lost_ = 0, held_ = 0;
};

}  // namespace touchable
