#include "tests/verify/slip.hpp"

#include <algorithm>
#include <sstream>

#include "tests/verify/certificate.hpp"

namespace touchable::verify {
namespace {

/// A straight slide within a facet towards the point closest to the goal.
struct Slide {
    Vec3 from, to_closest;
    real pressure = 0;

    /// What the rest of the way is longer than friction holds, after a share (0 to 1) of it.
    real lacking(const Surface& surface, real share) const {
        const Touch touch = surface.touch_at(surface.project(from + share * to_closest));
        return (1 - share) * length(to_closest) - touch.mu_dynamic * pressure;
    }
    /// How far a place is from being the first at which friction holds: from the way, or by what friction
    /// holds too little there, or too much before.
    real off_by(const Surface& surface, const Vec3& place) const {
        const real share = dot(place - from, to_closest) / dot(to_closest, to_closest);
        if (!(share >= 0 && share <= 1 + 1e-12L)) return length(to_closest);
        real off = std::fmax(length(place - from - share * to_closest), std::fabs(lacking(surface, share)));
        constexpr int looks = 32;
        for (int k = 0; k < looks; ++k) off = std::fmax(off, -lacking(surface, share * k / looks));
        return off;
    }
};

}  // namespace

Step judge_step(const Before& before, const ForceRow& row, const Facet& facet, const Surface& surface,
                std::string& why) {
    const real pressure = dot(row.proxy - row.goal, facet.normal);
    const real slack = position_slack(row.proxy, row.goal);
    if (before.tick + 1 != row.tick || !(before.facet == facet) || pressure <= slack) return Step::unknown;
    const Vec3 closest = row.goal + pressure * facet.normal;
    const Slide slide{before.proxy, closest - before.proxy, pressure};
    const Touch touch = surface.touch_at(surface.project(before.proxy));
    const real away = length(slide.to_closest), tolerance = 1e-9L * away + slack;
    const real stuck = touch.mu_static * pressure, sliding = touch.mu_dynamic * pressure;
    const auto on_the_cone = [&](real held) { return std::fabs(away - held) <= 1e-9L * held + slack; };
    if (on_the_cone(stuck) || on_the_cone(sliding)) return Step::unknown;
    const bool may_stay = away < (before.motion == Motion::slid ? sliding : stuck);
    const bool may_slide = away > (before.motion == Motion::none ? stuck : sliding);
    const real from_staying = length(row.proxy - before.proxy);
    if (may_stay && from_staying <= tolerance) return Step::right;
    const real from_sliding = slide.off_by(surface, row.proxy);
    if (may_slide && from_sliding <= tolerance) return Step::right;
    std::ostringstream text;
    text << (before.motion == Motion::none ? "at rest " : "moving ") << away
         << " from the closest point, held up to " << stuck << ", sliding " << sliding << ": moved "
         << from_staying << ", and is " << from_sliding << " from where the dynamic cone first holds it";
    why = text.str();
    return Step::wrong;
}

}  // namespace touchable::verify
