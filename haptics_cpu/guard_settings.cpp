#include "haptics_cpu/guard_settings.hpp"

#include <cmath>

namespace touchable {

// Written so that NaN is refused.
Result<void> validate(const GuardSettings& settings) {
    if (!(settings.max_force >= 1e-6 && settings.max_force <= 1e9))
        return usage_error("the device's force must be 1e-6 to 1e9 N");
    if (!(settings.max_stiffness >= 1e-3 && settings.max_stiffness <= 1e12))
        return usage_error("the device's stiffness must be 1e-3 to 1e12 N/m");
    if (settings.ramp_in_ticks < 0 || settings.ramp_out_ticks < 0)
        return usage_error("a ramp of force must be 0 ticks or more");
    if (!(settings.rise.per_tick > 0)) return usage_error("stiffness must rise by more than 0 N/m per tick");
    if (!(settings.damping >= 0 && std::isfinite(settings.damping)))
        return usage_error("damping must be 0 N s/m or more");
    if (!(settings.passivity >= 0 && std::isfinite(settings.passivity)))
        return usage_error("the passivity controller's damping must be 0 N s/m or more");
    return {};
}

}  // namespace touchable
