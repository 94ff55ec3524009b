// SPDX-License-Identifier: Apache-2.0
#pragma once

// Maps of a real globe from which make_scene makes a touchable one (SceneOptions::maps): colour, elevation, a
// mask of land and ocean, and optionally a haptic map. All are equirectangular; the caller owns their pixels,
// which must live until the scene is made.
//
// check_globe_maps refuses maps that make no globe, find_shore finds the sea level and which side of the mask
// is land.
// Threads: any; both only read.

#include <span>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A map of a whole globe in equirectangular projection: longitude -180 to 180 degrees from left to right,
/// north up. The caller owns its pixels.
struct GlobeMap {
    PlaneView samples{};              ///< codes of 1 or 3 channels
    std::span<const float> values{};  ///< or numbers of one channel, row by row
    int width = 0, height = 0;
    int channels = 1;
    int largest = 255;  ///< the code of white, and of 1 in a haptic map

    bool empty() const { return width == 0; }
    /// The stored value; numbers may be NaN or infinite.
    double at(int x, int y, int channel) const {
        if (values.empty()) return samples.sample(x, y, channel);
        return values[pixel_place(x, y, width)];
    }
};

/// The maps that a globe is made of, and what is known about them.
struct GlobeMaps {
    /// Where the ocean ends.
    struct Shore {
        double sea_level = 0;         ///< elevation up to this, land or not, is level with the ocean
        double top = 0;               ///< the highest elevation, above it
        bool bright_is_land = false;  ///< in the mask
        double mask_middle = 0;       ///< middle of the mask's range; brighter pixels are bright
        double agreement = 0;         ///< share of the globe's area where mask and elevation agree
    };

    GlobeMap colour;     ///< 3 channels, or 1
    GlobeMap elevation;  ///< 1 channel, in any unit
    GlobeMap mask;       ///< land and ocean, separated at half of its range
    GlobeMap haptic{};   ///< 3 channels: codes of stiffness, static and dynamic friction. Empty: by the mask
    Shore shore{};       ///< from find_shore
    double relief = 0.03;          ///< height of the highest place above the sea, share of the radius
    double smoothing_degrees = 1;  ///< narrower relief is in the height plane, not in the shape; 0 to 10
};

/// Refuses maps that make no globe: a map that is missing, of the wrong kind, or not twice as wide as high,
/// within a hundredth, and a relief or smoothing out of range. Does not check the shore.
Result<void> check_globe_maps(const GlobeMaps& maps);

/// Finds the sea level, unless it is given (in the elevation map's own unit), and the sense of the mask with
/// which both maps agree best. An error if they do not agree. check_globe_maps must accept the maps' shapes.
Result<GlobeMaps::Shore> find_shore(const GlobeMap& elevation, const GlobeMap& mask,
                                    std::optional<double> given);

}  // namespace touchable
