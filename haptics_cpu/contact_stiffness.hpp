#pragma once

#include <limits>
#include <optional>

#include "haptics_cpu/energy_account.hpp"

namespace touchable {

/// How the stiffness under a finger may rise while it touches. It falls at once: that takes energy away.
struct StiffnessRise {
    /// Only as far as this contact's losses pay for: a map of stiffness creates no energy.
    bool paid = false;
    double per_tick = std::numeric_limits<double>::infinity();  ///< N/m

    bool limited() const { return paid || per_tick < std::numeric_limits<double>::infinity(); }
};

/// What a rise of stiffness adds to the force per tick, at most, N, where a finger comes out of a hole that
/// is softer than what is around it: the goal may be deep behind the hole's wall by then. 0.4 N in 10 ms
/// leaves room within 0.5 N for what the hand itself does meanwhile.
inline constexpr double rise_from_hole = 0.04;

/// The stiffness in effect, never above the map's; a contact begins with the map's (docs/solver.md, Stiffness
/// that differs from place to place).
class ContactStiffness {
public:
    explicit ContactStiffness(const StiffnessRise& rise) : rise_(rise) {}

    /// N/m where the surface took the proxy, before the goal moved; nothing without contact.
    std::optional<double> carried(const Contact& contact) const;
    /// N/m at the proxy; 0 out of contact. After `account.move`.
    double in_effect(const Contact& contact, const EnergyAccount& account);
    void lift() { limited_ = from_hole_ = false; }

private:
    double risen(double before, double map, const EnergyAccount& account);

    StiffnessRise rise_;
    bool limited_ = false;    // in a contact whose rises are limited
    bool from_hole_ = false;  // in a hole, or out of one and not yet as stiff as the map
    double stiffness_ = 0;
    double paid_ = 0;  // joules lost in this contact and not yet spent
};

}  // namespace touchable
