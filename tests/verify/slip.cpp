#include "tests/verify/slip.hpp"

#include <algorithm>
#include <sstream>

#include "tests/verify/certificate.hpp"

namespace touchable::verify {
namespace {

bool same(real a, real b) {
    return std::fabs(a - b) < 1e-12L;
}

}  // namespace

Step judge_step(const Before& before, const ForceRow& row, const Facet& facet, const Touch& touch,
                std::string& why) {
    const real pressure = dot(row.proxy - row.goal, facet.normal);
    const real slack = position_slack(row.proxy, row.goal);
    if (before.tick + 1 != row.tick || !(before.facet == facet) || pressure <= slack ||
        !same(before.touch.mu_static, touch.mu_static) || !same(before.touch.mu_dynamic, touch.mu_dynamic))
        return Step::unknown;
    const Vec3 closest = row.goal + pressure * facet.normal, from_closest = before.proxy - closest;
    const real away = length(from_closest), held = touch.mu_static * pressure;
    if (std::fabs(away - held) <= 1e-9L * held + slack) return Step::unknown;
    const bool may_stay = away < held, may_slide = !may_stay || !before.at_rest;
    const real left = away > 0 ? std::min<real>(1, touch.mu_dynamic * pressure / away) : 1;
    const real from_staying = length(row.proxy - before.proxy);
    const real from_sliding = length(row.proxy - closest - left * from_closest);
    const real tolerance = 1e-9L * away + slack;
    if ((may_stay && from_staying <= tolerance) || (may_slide && from_sliding <= tolerance))
        return Step::right;
    std::ostringstream text;
    text << (before.at_rest ? "at rest " : "moving ") << away << " from the closest point, held up to "
         << held << ": moved " << from_staying << ", and is " << from_sliding << " from the dynamic cone";
    why = text.str();
    return Step::wrong;
}

}  // namespace touchable::verify
