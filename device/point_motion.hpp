// SPDX-License-Identifier: Apache-2.0
#pragma once

// Motions of one point, the same bits everywhere. HeldHandle: the end of a simulated device in a hand, a mass
// under the device's force, friction and the hand's spring. LedPoint: follows a goal without overshoot, as a
// finger follows a pointer. PlausibleMotion: leaves out positions of a finger that no hand can have reached,
// so that a bit lost on a wire is no blow.
//
//   HeldHandle handle(dynamics, 0.001);
//   every millisecond: handle.intend(meant), handle.advance(newtons), then handle.reading()
//
// Lengths are metres of the device or of the world, as the caller chooses; times are seconds unless a name
// says ns.
// Threads: one uses an object, which neither allocates nor waits, so that the haptic thread can.

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace touchable {

/// The body that a hand holds: mass and losses of device and hand together, equal in all directions.
struct HandleDynamics {
    double mass = 0.5;    ///< kg, > 0
    double damping = 5;   ///< N s/m, >= 0 and at most mass / period
    double friction = 0;  ///< N, Coulomb's, of the device's joints
    double quantum = 0;   ///< m, step of position readings; 0: exact
    /// N/m, of the spring between the handle and the hand's target.
    double hand_stiffness = 300;
};

/// The end of a device in a hand, without hardware: a mass under a device's force (held over each period, as
/// electronics hold it), viscous and Coulomb friction, and the hand's spring towards its target. Device
/// metres, newtons, seconds. Without Coulomb friction its motion is exact; with it, exact for a friction that
/// is constant over a twentieth of the period, at whose end the body may come to rest (implicit, after
/// Moreau: no drift at rest, no chatter). The same bits everywhere.
class HeldHandle {
public:
    /// At rest at 0, which is also the hand's target.
    HeldHandle(const HandleDynamics& dynamics, double period_s);

    void put(const glm::dvec3& place, const glm::dvec3& velocity) {
        place_ = place;
        velocity_ = velocity;
    }
    void intend(const glm::dvec3& place) { intended_ = place; }
    /// Advances by one period under a constant device force.
    void advance(const glm::dvec3& force) {
        for (int k = 0; k < steps_; ++k) step(force);
    }

    const glm::dvec3& place() const { return place_; }
    const glm::dvec3& velocity() const { return velocity_; }
    /// The position as the device's encoders measure it: in steps of `quantum`.
    glm::dvec3 reading() const {
        const double q = dynamics_.quantum;
        if (!(q > 0)) return place_;
        return q * glm::dvec3(std::floor(place_.x / q + 0.5), std::floor(place_.y / q + 0.5),
                              std::floor(place_.z / q + 0.5));
    }

private:
    void step(const glm::dvec3& force);

    HandleDynamics dynamics_;
    int steps_;  // per period
    // The integral of exp(A s) over a step, A the body's matrix: what position and velocity gain, per
    // velocity and per acceleration at the step's beginning.
    double place_per_velocity_, place_per_acceleration_, velocity_per_velocity_, velocity_per_acceleration_;
    glm::dvec3 place_{0.0}, velocity_{0.0}, intended_{0.0};
};

/// A point that follows a goal like a critically damped spring: without overshoot, smooth in speed, and exact
/// for a goal that is constant over a period. It is slower along one direction, in which the goal may jump,
/// than across. The same bits everywhere.
class LedPoint {
public:
    /// Time constants.
    struct Times {
        double across_s;  ///< across the slower direction, s, at least a period
        double along_s;   ///< along it, s, at least a period
    };

    LedPoint(const Times& times, double period_s)
        : period_s_(period_s),
          across_(response(times.across_s, period_s)),
          along_(response(times.along_s, period_s)) {
        assert(period_s > 0 && times.across_s >= period_s && times.along_s >= period_s);
    }

    /// Puts the point at rest.
    void put(const glm::dvec3& place) {
        place_ = place;
        velocity_ = glm::dvec3(0);
    }
    /// Advances by one period towards `goal`, at `max_speed` (> 0) at most. `along`: unit vector of the
    /// slower direction, or zero if there is none.
    void follow(const glm::dvec3& goal, const glm::dvec3& along, double max_speed);

    /// Moves the point and keeps its velocity.
    void shift(const glm::dvec3& way) { place_ += way; }

    const glm::dvec3& place() const { return place_; }
    const glm::dvec3& velocity() const { return velocity_; }

private:
    /// Offset from the goal and velocity after a period, per unit of each before it.
    struct Response {
        double place_per_place, place_per_velocity, velocity_per_place, velocity_per_velocity;
    };
    static Response response(double time_constant, double period_s);

    double period_s_;
    Response across_, along_;
    glm::dvec3 place_{0.0}, velocity_{0.0};
};

/// Leaves out impossible positions of a finger. A hand moves a few metres in a second; a bit that is lost on
/// a wire moves the position through the whole room. A position that the finger cannot have reached from the
/// last one is left out, however often that happens. If all positions after such a leap follow each other as
/// a hand can move, they are accepted after `lost_ns`: until then the position counts as unknown, so that the
/// force guard has taken the force away before the finger appears elsewhere.
class PlausibleMotion {
public:
    static constexpr double fastest = 5;       ///< m/s
    static constexpr double longest_s = 0.01;  ///< most time that counts between two positions
    static constexpr double slack = 0.002;  ///< m, allowed between any two positions: noise, late timestamps
    static constexpr double farthest = 5;   ///< m from the device's centre
    static constexpr std::int64_t lost_ns = 150'000'000;  ///< longer than the guard takes to end its force

    /// Returns the position if it is accepted; nothing: it is left out. Times do not go back.
    std::optional<glm::dvec3> believe(const glm::dvec3& place, std::int64_t time_ns);
    /// Accepts any position next, after a long time without one.
    void forget() { *this = {}; }

private:
    struct Seen {
        glm::dvec3 place{0.0};
        std::int64_t time_ns = 0;
    };
    static bool reaches(const Seen& from, const glm::dvec3& place, std::int64_t time_ns) {
        const double seconds = std::min(static_cast<double>(time_ns - from.time_ns) * 1e-9, longest_s);
        return glm::length(place - from.place) <= slack + fastest * seconds;
    }

    std::optional<Seen> last_;       // accepted
    std::optional<Seen> elsewhere_;  // newest of the positions after a leap
    std::int64_t leapt_ns_ = 0;      // time of the leap
};

/// Offset of finger `finger` of `fingers` from the hand's centre (x right, y up), in the unit of `spread`:
/// evenly on a circle of radius `spread`, the first one to the right; a single finger at the centre.
glm::dvec2 finger_offset(int finger, int fingers, double spread);

}  // namespace touchable
