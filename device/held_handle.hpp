#pragma once

#include <glm/vec3.hpp>

namespace touchable {

/// What a hand holds and how: masses and losses of device and hand together, as one body, alike in all
/// directions.
struct HandleDynamics {
    double mass = 0.5;    ///< kg, > 0
    double damping = 5;   ///< N s/m, >= 0 and at most mass / period
    double friction = 0;  ///< N, Coulomb's, of the device's joints
    double quantum = 0;   ///< m, of a position reading; 0: read exactly
    double hand_stiffness =
        300;  ///< N/m, of the spring between the handle and where the person means it to be
};

/// The end of a device in a hand, where nothing is connected: a mass on which act a device's force, held over
/// each period as electronics hold it, viscous and Coulomb friction, and the spring of a hand towards a place
/// the person means. Device metres, newtons, seconds. Without Coulomb friction its motion is exact; with it,
/// exact for a friction that is constant over a twentieth of the period, at whose end the body may come to
/// rest (implicit, as Moreau has it: no drift at rest, no chatter). The same bits everywhere.
class HeldHandle {
public:
    /// At rest at 0, meant to be there.
    HeldHandle(const HandleDynamics& dynamics, double period_s);

    void put(const glm::dvec3& place, const glm::dvec3& velocity);
    void intend(const glm::dvec3& place) { intended_ = place; }
    /// One period, under a device's constant force.
    void advance(const glm::dvec3& force);

    const glm::dvec3& place() const { return place_; }
    const glm::dvec3& velocity() const { return velocity_; }
    /// The place as the device's encoders measure it: in steps of `quantum`.
    glm::dvec3 reading() const;

private:
    void step(const glm::dvec3& force);

    HandleDynamics dynamics_;
    int steps_;  // of a period
    // The integral of exp(A s) over a step, A the body's matrix: what place and velocity gain, per velocity
    // and per acceleration at its beginning.
    double place_per_velocity_, place_per_acceleration_, velocity_per_velocity_, velocity_per_acceleration_;
    glm::dvec3 place_{0.0}, velocity_{0.0}, intended_{0.0};
};

}  // namespace touchable
