#include "haptics_cpu/contact_damping.hpp"

#include <glm/geometric.hpp>

#include "haptics_cpu/tick_velocity.hpp"

namespace touchable {

using glm::dot;
using glm::dvec3;

dvec3 ContactDamping::force(const EnergyAccount& account, double stiffness, const dvec3& velocity,
                            int ticks) {
    if (!(stiffness > 0)) {
        lift();
        return dvec3(0.0);
    }
    rate_ = filtered_velocity(rate_, account.stretched(), ticks);
    const dvec3 damper = b_ * rate_;
    if (dot(damper, velocity) > 0) return dvec3(0.0);
    const dvec3& stretch = account.stretch();
    const double inward = -dot(damper, stretch), spring = stiffness * dot(stretch, stretch);
    if (spring == 0) return dvec3(0.0);
    return inward > spring ? damper * (spring / inward) : damper;
}

}  // namespace touchable
