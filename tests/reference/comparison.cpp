#include "tests/reference/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/reference/certificate.hpp"

namespace touchable::reference {

namespace {

bool all_in(const Place& some, const Place& others) {
    return std::all_of(some.parts.begin(), some.parts.end(),
                       [&](const Place::Part& part) { return others.has(part.corner); });
}

}  // namespace

Comparison compare(const Surface& surface, const Proxy& before, const Proxy& after, const Contact& contact) {
    const Vec goal(contact.goal), proxy(contact.proxy);
    const Finger start = finger_of(surface, before);
    const Solution truth = solve(surface, start, goal, goal);
    const Vec& p = truth.finger.point;
    Comparison result;
    result.capped = truth.capped;

    const bool touching = truth.finger.place.has_value();
    result.same_basin = touching == after.on_surface();
    if (touching && result.same_basin) {
        const Place here = reduced(place_of(surface, after)), there = reduced(*truth.finger.place);
        result.same_basin = all_in(here, there) || all_in(there, here);
    }

    Real rounding = 1e-13L * (length(p) + length(goal));
    // With friction the place where the slide began tells in the end.
    if (touching && contact.touching) rounding += rounding_at(surface, contact.proxy);
    if (start.place) rounding += rounding_at(surface, before.point);
    const Real have = length(proxy - goal), least = length(p - goal);
    const Real had = length(start.point - goal);
    result.farther = (have - rounding - had) / (1 + had);
    if (have > rounding) result.distance_ratio = have / std::max(least, rounding);
    if (touching && result.same_basin && least > rounding) {
        const Vec cross = glm::cross(proxy - goal, p - goal);
        const Real radians = std::max(Real(0), length(cross) / have - rounding) / least;
        result.angle_degrees = radians * 180 / 3.14159265358979323846L;
    }
    return result;
}

}  // namespace touchable::reference
