#include "haptics_cpu/contact_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

std::optional<double> ContactStiffness::carried(const Contact& contact) const {
    if (!limited_ || !contact.carried_stiffness) return contact.carried_stiffness;
    return std::min(*contact.carried_stiffness, stiffness_);
}

/// From tick to tick of a contact.
double ContactStiffness::risen(double before, double map, const EnergyAccount& account) {
    double most = rise_.per_tick;
    const double stretch2 = glm::dot(account.stretch(), account.stretch());
    if (from_hole_ && stretch2 > 0) most = std::min(most, rise_from_hole / std::sqrt(stretch2));
    // At a stiffness that stays, holding a force creates a little, friction and drops lose much.
    const double stays = account.energy(before);
    paid_ += std::max(0.0, account.allowed() - stays);
    const double stiffness = std::min(map, before + most);
    const double cost = account.energy(stiffness) - stays;
    if (!rise_.paid || cost <= paid_) {
        paid_ = std::max(0.0, paid_ - cost);
        return stiffness;
    }
    const double affordable = std::clamp(account.stiffness(stays + paid_), before, stiffness);
    paid_ = 0;
    return affordable;
}

double ContactStiffness::in_effect(const Contact& contact, const EnergyAccount& account) {
    const double map = contact.properties.stiffness;
    from_hole_ = from_hole_ || contact.hole_share > 0;
    if (!rise_.limited() && !from_hole_) return map;
    const std::optional<double> carried = this->carried(contact);
    if (carried && contact.touching) {
        stiffness_ = risen(*carried, map, account);
    } else {
        paid_ = 0;
        stiffness_ = map;
    }
    from_hole_ = contact.touching && (contact.hole_share > 0 || (from_hole_ && stiffness_ < map));
    limited_ = contact.touching && (rise_.limited() || from_hole_);
    return stiffness_;
}

}  // namespace touchable
