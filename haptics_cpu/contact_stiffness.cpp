#include "haptics_cpu/contact_stiffness.hpp"

#include <algorithm>

namespace touchable {

std::optional<double> ContactStiffness::carried(const Contact& contact) const {
    if (!touching_ || !contact.carried_stiffness) return contact.carried_stiffness;
    return std::min(*contact.carried_stiffness, stiffness_);
}

double ContactStiffness::in_effect(const Contact& contact, const EnergyAccount& account) {
    const double map = contact.properties.stiffness;
    if (!rise_.limited()) return map;
    const std::optional<double> carried = this->carried(contact);
    touching_ = contact.touching;
    if (!carried || !touching_) {
        paid_ = 0;
        return stiffness_ = map;
    }
    const double before = *carried;
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
