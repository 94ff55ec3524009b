#include "haptics_cpu/guard_settings.hpp"

#include <cmath>
#include <string>
#include <utility>

namespace touchable {

namespace {

Error must_be(const char* name, const char* range, Hints hints = {}) {
    return usage_error(std::string(name) + " must be a number " + range, std::move(hints));
}

}  // namespace

// Written so that NaN is refused.
Result<void> validate(const GuardSettings& settings) {
    if (!(settings.max_force >= 1e-6 && settings.max_force <= 1e9))
        return must_be("the device's force", "from 1e-6 to 1e9 N", {{Setting::max_force}});
    if (!(settings.max_stiffness >= 1e-3 && settings.max_stiffness <= 1e12))
        return must_be("the device's stiffness", "from 1e-6 to 1e9 N/mm", {{Setting::max_stiffness}});
    if (settings.ramp_in_ticks < 0 || settings.ramp_out_ticks < 0)
        return must_be("a ramp of force", "of ticks, 0 or more");
    if (!(settings.rise.per_tick > 0))
        return must_be("the rise of stiffness", "above 0 N/mm per second", {{Setting::stiffness_rise}});
    if (!(settings.damping >= 0 && std::isfinite(settings.damping)))
        return must_be("damping", "of N s/m, 0 or more", {{Setting::damping}});
    if (!(settings.passivity >= 0 && std::isfinite(settings.passivity)))
        return must_be("the passivity controller's damping", "of N s/m, 0 or more", {{Setting::passivity}});
    if (settings.stale_after_ns < 0 || settings.stale_after_ns > 3'600'000'000'000)
        return must_be("the age of a stale surface", "from 0 to 3600000 ms", {{Setting::stale_after}});
    return {};
}

}  // namespace touchable
