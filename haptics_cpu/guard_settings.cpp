#include "haptics_cpu/guard_settings.hpp"

#include <cmath>
#include <string>

namespace touchable {

namespace {

Error must_be(const char* name, const char* range) {
    return usage_error(std::string(name) + " must be a number " + range);
}

}  // namespace

// Written so that NaN is refused.
Result<void> validate(const GuardSettings& settings, const GuardNames& names) {
    if (!(settings.max_force >= 1e-6 && settings.max_force <= 1e9))
        return must_be(names.max_force, "from 1e-6 to 1e9 N");
    if (!(settings.max_stiffness >= 1e-3 && settings.max_stiffness <= 1e12))
        return must_be(names.max_stiffness, "from 1e-6 to 1e9 N/mm");
    if (settings.ramp_in_ticks < 0 || settings.ramp_out_ticks < 0)
        return must_be(names.ramp, "of ticks, 0 or more");
    if (!(settings.rise.per_tick > 0)) return must_be(names.rise, "above 0 N/mm per second");
    if (!(settings.damping >= 0 && std::isfinite(settings.damping)))
        return must_be(names.damping, "of N s/m, 0 or more");
    if (!(settings.passivity >= 0 && std::isfinite(settings.passivity)))
        return must_be(names.passivity, "of N s/m, 0 or more");
    return {};
}

}  // namespace touchable
