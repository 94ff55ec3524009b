#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What the haptic pictures of a clip ask of a device. Shares are of the pixels that have a surface.
struct HapticValues {
    double stiffest = 0;      ///< N/mm
    double too_stiff = 0;     ///< share that is stiffer than stiffest_of_devices
    double more_dynamic = 0;  ///< share with dynamic friction above static friction
    /// Share that has the value of no neighbour on either side, though these agree among themselves: noise of
    /// a codec that mixes materials.
    double mixed = 0;
};

/// N/mm. The stiffest that a hand-held device renders by what its makers and the literature say
/// (docs/devices.md); most render less.
inline constexpr double stiffest_of_devices = 3.0;

class HapticValuesEstimator {
public:
    explicit HapticValuesEstimator(const Scene& scene) : scene_(scene) {}

    /// Pixels that are set to 1, row by row, of those shares; nothing: nobody wants to know.
    struct Where {
        std::vector<std::uint8_t> too_stiff, more_dynamic, mixed;
    };
    /// Looks at a frame with a haptic picture.
    void add(const RawFrame& frame, Where* where = nullptr);
    HapticValues values() const;

private:
    const Scene scene_;
    double stiffest_ = 0;
    std::int64_t pixels_ = 0, too_stiff_ = 0, more_dynamic_ = 0, mixed_ = 0;
};

}  // namespace touchable
