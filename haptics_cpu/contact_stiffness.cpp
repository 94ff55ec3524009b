#include "haptics_cpu/contact_stiffness.hpp"

#include <algorithm>

namespace touchable {

double ContactStiffness::carried(const Contact& contact) const {
    return touching_ ? std::min(contact.carried_stiffness, stiffness_) : contact.carried_stiffness;
}

double ContactStiffness::in_effect(const Contact& contact, const EnergyAccount& account) {
    const double map = contact.properties.stiffness;
    if (!rise_.limited()) return map;
    const double before = carried(contact);
    touching_ = contact.touching;
    if (!(before > 0) || !touching_) {
        paid_ = 0;
        return stiffness_ = map;
    }
    // At a stiffness that stays, holding a force creates a little, friction and drops lose much.
    const double stays = account.energy(before);
    paid_ += std::max(0.0, account.allowed() - stays);
    stiffness_ = std::min(map, before + rise_.per_tick);
    const double cost = account.energy(stiffness_) - stays;
    if (!rise_.paid || cost <= paid_) {
        paid_ = std::max(0.0, paid_ - cost);
        return stiffness_;
    }
    stiffness_ = std::clamp(account.stiffness(stays + paid_), before, stiffness_);
    paid_ = 0;
    return stiffness_;
}

}  // namespace touchable
