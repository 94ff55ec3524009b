#include "device/stiffness_search.hpp"

#include <algorithm>

#include "device/spring_trial.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr double softest = 100, rung = 1.4142135623730951;
constexpr double most_newtons = 1.5;

}  // namespace

Result<StiffnessFinding> find_stiffness(HapticDevice& device, const TickPace& pace,
                                        const std::function<void(double)>& tries) {
    if (device.capabilities().axes_driven == 0)
        return usage_error(device.name() + " exerts no force, so it has no largest stiffness");
    const DeviceLimits limits = device.limits();
    StiffnessFinding finding;
    finding.most_force = std::min(most_newtons, limits.max_force / 2);
    finding.moved = false;
    SpringTrial trial(device, pace, finding.most_force);
    for (double stiffness = std::min(softest, limits.max_stiffness);; stiffness *= rung) {
        stiffness = std::min(stiffness, limits.max_stiffness);
        if (tries) tries(stiffness);
        TRY_ASSIGN(const auto rest, trial.wait_for_rest());
        TRY_ASSIGN(auto verdict, trial.try_spring(stiffness, rest));
        finding.moved = finding.moved || verdict.moved;
        if (!verdict.quiet) {
            finding.shaking = stiffness;
            finding.why = verdict.why;
            return finding;
        }
        finding.quiet = stiffness;
        if (stiffness >= limits.max_stiffness) return finding;
    }
}

}  // namespace touchable
