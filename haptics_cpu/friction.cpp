#include "haptics_cpu/friction.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <utility>

namespace touchable {

namespace {

// A proxy that was stopped on the cone is inside it, whatever rounding says.
constexpr double on_the_cone = 1.0 + 2e-9;

constexpr double never_held = std::numeric_limits<double>::infinity();

/// The share (0 to 1) of the motion's way after which a sliding proxy comes to rest, where friction is level.
double sliding_share(const FrictionCone& cone, const Motion& motion) {
    if (cone.stopping == 0) return 1.0;
    const double share = 1.0 - cone.stopping * std::sqrt(motion.load2 / glm::dot(motion.way, motion.way));
    return share > 0 ? share : 0.0;
}

/// True where it is certain, without a root or a division, that a motion goes on beyond `length` image steps:
/// that the share of its way to there, s = length / (1 - length stretch), is less than level friction leaves
/// it.
bool goes_beyond(double length, const ImageStep& step, const FrictionCone& cone, const Motion& motion) {
    constexpr double certain = 1.0 + 1e-6;  // by far more than roundings can be wrong
    const double rest = 1.0 - length * (1.0 + step.stretch), whole = rest + length;  // (1 - s) : 1
    const double held = cone.stopping * whole;
    return rest > 1e-6 &&
           held * held * motion.load2 * certain < rest * rest * glm::dot(motion.way, motion.way);
}

/// What friction lacks to hold a proxy on its way from u = 0 to 1, as a cubic: held where it is not positive.
struct Shortfall {
    std::array<double, 4> c;

    double at(double u) const { return ((c[3] * u + c[2]) * u + c[1]) * u + c[0]; }
    double slope(double u) const { return (3 * c[3] * u + 2 * c[2]) * u + c[1]; }
    /// What roundings may make of a value.
    double rounding() const {
        return 0x1p-51 * (std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]) + std::abs(c[3]));
    }
    /// Enough for it: that all of Bernstein's coefficients are.
    bool is_positive() const {
        return c[0] > 0 && 3 * c[0] + c[1] > 0 && 3 * c[0] + 2 * c[1] + c[2] > 0 &&
               c[0] + c[1] + c[2] + c[3] > 0;
    }
    /// Where it turns between 0 and 1; 1 for a turn that is elsewhere.
    std::array<double, 2> turns() const {
        std::array<double, 2> out{1, 1};
        const double discriminant = c[2] * c[2] - 3 * c[3] * c[1];
        if (!(discriminant > 0)) return out;
        const double q = -(c[2] + (c[2] < 0 ? -1.0 : 1.0) * std::sqrt(discriminant));
        const double first = c[3] == 0 ? never_held : q / (3 * c[3]), second = c[1] / q;
        if (first > 0 && first < 1) out[0] = first;
        if (second > 0 && second < 1) out[1] = second;
        return out;
    }
    /// Its zero between two places without a turn between them: positive at `low`, not at `high`. Newton's
    /// steps, and halves where they would leave what is known.
    double zero(double low, double high) const {
        const double near_enough = rounding();
        double u = low + (high - low) / 2;
        for (int step = 0; step < 100 && u > low && u < high; ++step) {
            const double value = at(u);
            if (std::abs(value) <= near_enough) return u;
            (value > 0 ? low : high) = u;
            const double steepness = slope(u);
            u = steepness == 0 ? low : u - value / steepness;
            if (!(u > low && u < high)) u = low + (high - low) / 2;
        }
        return high;
    }
};

/// The first u from 0 to 1 at which none of them lacks anything.
double first_held(std::span<const Shortfall> all) {
    std::array<double, 5> ends{1, 1, 1, 1, 1};  // of pieces without a turn, in order
    bool at_once = true;
    for (const Shortfall& one : all) {
        if (one.is_positive()) return never_held;
        at_once &= one.c[0] <= 0;
        for (double turn : one.turns())
            for (double& end : ends)
                if (turn < end) std::swap(turn, end);
    }
    if (at_once) return 0;
    double low = 0;
    for (const double high : ends) {
        double first = never_held;
        for (const Shortfall& one : all) {
            if (!(one.at(low) > 0 && one.at(high) <= 0)) continue;
            const double u = one.zero(low, high);
            const bool held = std::all_of(all.begin(), all.end(), [&](const Shortfall& other) {
                return &other == &one || other.at(u) <= other.rounding();
            });
            if (held) first = std::min(first, u);
        }
        if (first <= 1) return first;
        low = high;
    }
    return never_held;
}

/// Of a way of `span` image steps, by mu at the cell's corners. After L steps (1 - L (1 + t)) : (1 - L t) of
/// the way is left, and mu is quadratic in L; both times 1 - L t, and over the way's length.
Shortfall shortfall(const std::array<double, 4>& mu, double load_per_way, const ImageStep& step,
                    const CellPoint& from, double span) {
    const double da = span * step.dx, db = span * step.dy, t = span * step.stretch;
    const double along_a = mu[1] - mu[0], along_b = mu[2] - mu[0];
    const double twist = (mu[3] - mu[2]) - along_a;
    const double m0 = load_per_way * bilinear(from.a, from.b, mu[0], mu[1], mu[2], mu[3]);
    const double m1 = load_per_way * (along_a * da + along_b * db + twist * (from.a * db + from.b * da));
    const double m2 = load_per_way * (twist * da * db);
    return {{1.0 - m0, t * m0 - m1 - (span + t), t * m1 - m2, t * m2}};
}

double uneven_stop(const FrictionCone& cone, const Motion& motion, const ImageStep& step,
                   const CellPoint& from, double reach) {
    const double to_foot = step.length_at(1.0), span = std::min(reach, to_foot);
    const double way2 = glm::dot(motion.way, motion.way);
    const double load_per_way = way2 > 0 ? std::sqrt(motion.load2 / way2) : 0.0;
    if (!(load_per_way > 0) || !(span < never_held)) return to_foot;
    if (load_per_way == std::numeric_limits<double>::infinity()) return 0;
    bool one_map = true;
    for (std::size_t k = 0; k < 4; ++k) one_map &= cone.sliding[k] <= cone.most[k];
    std::array<Shortfall, 2> lacks;
    lacks[0] = shortfall(cone.sliding, load_per_way, step, from, span);
    if (!one_map) lacks[1] = shortfall(cone.most, load_per_way, step, from, span);
    const double u = first_held({lacks.data(), one_map ? 1U : 2U});
    if (u <= 1) return u * span;
    return span == to_foot ? to_foot : never_held;
}

}  // namespace

Slip stribeck_slip(double speed, double stribeck_speed) {
    const double ratio = speed / stribeck_speed;
    return {1.0 / (1.0 + ratio * ratio), false};
}

bool is_slow(double speed, double stribeck_speed) {
    return speed < 0.1 * stribeck_speed;
}

FrictionCone cone_over(const CornerProperties& corners, const CellPoint& at, bool sliding, const Slip& slip) {
    FrictionCone cone;
    for (std::size_t k = 0; k < 4; ++k) {
        const double mu_d = corners[k].dynamic_friction, mu_s = corners[k].static_friction;
        cone.sliding[k] = mu_d + slip.static_share * (mu_s - mu_d);
        cone.most[k] = mu_s;
        cone.level &= cone.sliding[k] == cone.sliding[0] && mu_s == cone.most[0];
    }
    const auto here = [&at](const std::array<double, 4>& mu) {
        return bilinear(at.a, at.b, mu[0], mu[1], mu[2], mu[3]);
    };
    const double mu_s = here(cone.most);
    cone.stopping = std::min(here(cone.sliding), mu_s);
    cone.resting = sliding ? cone.stopping : mu_s;
    return cone;
}

bool rests(const FrictionCone& cone, const Motion& motion) {
    const double mu2 = cone.resting * cone.resting;
    return mu2 > 0 && glm::dot(motion.way, motion.way) <= mu2 * motion.load2 * on_the_cone;
}

double stopping_length(const FrictionCone& cone, const Motion& motion, const ImageStep& step,
                       const CellPoint& from, double reach) {
    if (!cone.level) return uneven_stop(cone, motion, step, from, reach);
    if (goes_beyond(reach, step, cone, motion)) return never_held;
    return step.length_at(sliding_share(cone, motion));
}

}  // namespace touchable
