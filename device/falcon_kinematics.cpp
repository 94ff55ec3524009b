#include "device/falcon_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

// Metres, by the letters of Stamper's drawing.
constexpr double upper_arm = 0.060;                          // a: from the motor's axis to the knee
constexpr double shin = 0.1025;                              // b: side of the parallelogram
constexpr double shin_ends = 0.01125 + 0.01125;              // d + e: from its sides to knee and grip
constexpr double grip_out = 0.01443, grip_along = -0.025;    // c, f: of the shin's end at the grip
constexpr double motor_out = 0.040, motor_along = -0.02309;  // r, s: of the motor's axis
constexpr double middle = 0.125;                             // of the reach, from the motors' plane
constexpr double degree = pi / 180;
constexpr double arms_at[3] = {105 * degree, -15 * degree, -135 * degree};  // around z, from x

constexpr double radians_per_count = 2 * pi / (4 * 320) * (14.25 / 110);
constexpr double angle_at_zero = 35 * degree;

constexpr double words_per_newton_metre = -10000;

/// The grip as one arm sees it. Its knee is at (upper_arm cos, upper_arm sin) in the plane of `out` and
/// `ahead`, and `leg` from the grip's joint, which is there at (out, ahead); `along` is across the plane.
struct Leg {
    glm::dvec3 out_axis, along_axis;
    double out = 0, along = 0, ahead = 0;
    double shin_height = 0;  // the parallelogram's, in the plane; not a number: it does not reach across
    double leg() const { return shin_ends + shin_height; }
};

Leg leg_of(std::size_t arm, const glm::dvec3& place) {
    const double c = cosine(arms_at[arm]), s = sine(arms_at[arm]);
    Leg leg;
    leg.out_axis = {c, s, 0};
    leg.along_axis = {-s, c, 0};
    leg.out = glm::dot(leg.out_axis, place) - motor_out + grip_out;
    leg.along = glm::dot(leg.along_axis, place) - motor_along + grip_along;
    leg.ahead = place.z + middle;
    leg.shin_height = std::sqrt(shin * shin - leg.along * leg.along);
    return leg;
}

/// How much longer than the leg, squared, the way from knee to grip is; 0 where the mechanism closes. With
/// its slopes over the grip's place and the arm's angle.
struct Gap {
    double size = 0;
    glm::dvec3 over_place{0.0};
    double over_angle = 0;
};

Gap gap_of(const Leg& leg, double angle) {
    const double c = cosine(angle), s = sine(angle);
    const double out = leg.out - upper_arm * c, ahead = leg.ahead - upper_arm * s;
    Gap gap;
    gap.size = out * out + ahead * ahead - leg.leg() * leg.leg();
    gap.over_place = 2.0 * (out * leg.out_axis + leg.leg() * leg.along / leg.shin_height * leg.along_axis +
                            glm::dvec3(0, 0, ahead));
    gap.over_angle = 2 * upper_arm * (leg.out * s - leg.ahead * c);
    return gap;
}

/// Of all three arms: rows over the place as columns of the transposed matrix.
struct Gaps {
    glm::dvec3 sizes{0.0}, over_angles{0.0};
    glm::dmat3 over_place{0.0};
};

Gaps gaps_of(const FalconAngles& angles, const glm::dvec3& place) {
    Gaps gaps;
    glm::dmat3 rows(0.0);
    for (std::size_t arm = 0; arm < 3; ++arm) {
        const Gap gap = gap_of(leg_of(arm, place), angles[arm]);
        const auto at = static_cast<glm::length_t>(arm);
        gaps.sizes[at] = gap.size;
        gaps.over_angles[at] = gap.over_angle;
        rows[at] = gap.over_place;
    }
    gaps.over_place = glm::transpose(rows);
    return gaps;
}

/// Both places that close the mechanism may be found; the one before the motors, knees outward, is meant.
bool is_the_arms_own(const FalconAngles& angles, const glm::dvec3& place) {
    const auto own = falcon_angles(place);
    if (!own) return false;
    for (std::size_t arm = 0; arm < 3; ++arm)
        if (std::abs((*own)[arm] - angles[arm]) > 1e-6) return false;
    return true;
}

}  // namespace

double falcon_angle(std::int16_t count) {
    return angle_at_zero + radians_per_count * count;
}

/// Motor's axis, knee and grip's joint are a triangle of known sides.
std::optional<FalconAngles> falcon_angles(const glm::dvec3& place) {
    FalconAngles angles{};
    for (std::size_t arm = 0; arm < 3; ++arm) {
        const Leg leg = leg_of(arm, place);
        const double away = std::sqrt(leg.out * leg.out + leg.ahead * leg.ahead);
        const double at_motor =
            (away * away + upper_arm * upper_arm - leg.leg() * leg.leg()) / (2 * upper_arm * away);
        if (!(std::abs(at_motor) <= 1)) return std::nullopt;
        angles[arm] = arctangent2(leg.ahead, leg.out) - (pi / 2 - arcsine(at_motor));
    }
    return angles;
}

std::optional<FalconPose> falcon_pose(const FalconAngles& angles, const glm::dvec3& start) {
    constexpr int most_steps = 50;
    constexpr double longest_step = 0.02, converged = 1e-11;
    glm::dvec3 place = start;
    for (int step = 0; step < most_steps; ++step) {
        const Gaps gaps = gaps_of(angles, place);
        const glm::dvec3 move = -(glm::inverse(gaps.over_place) * gaps.sizes);
        const double length = glm::length(move);
        if (!std::isfinite(length)) return std::nullopt;
        place += length > longest_step ? move * (longest_step / length) : move;
        if (length > converged) continue;
        if (glm::length(place) > falcon_edge || !is_the_arms_own(angles, place)) return std::nullopt;
        FalconPose pose{place, glm::dmat3(0.0)};
        const Gaps closed = gaps_of(angles, place);
        const glm::dmat3 over_gaps = glm::inverse(closed.over_place);
        for (glm::length_t arm = 0; arm < 3; ++arm)
            pose.metres_per_radian[arm] = -over_gaps[arm] * closed.over_angles[arm];
        return pose;
    }
    return std::nullopt;
}

std::array<std::int16_t, 3> falcon_motor_words(const FalconPose& pose, const glm::dvec3& newtons) {
    const glm::dvec3 words = words_per_newton_metre * (glm::transpose(pose.metres_per_radian) * newtons);
    const double largest = std::max({std::abs(words.x), std::abs(words.y), std::abs(words.z)});
    if (!std::isfinite(largest)) return {};
    const double shortened = largest > falcon_largest_word ? falcon_largest_word / largest : 1.0;
    std::array<std::int16_t, 3> sent{};
    for (glm::length_t arm = 0; arm < 3; ++arm)
        sent[static_cast<std::size_t>(arm)] = static_cast<std::int16_t>(std::round(words[arm] * shortened));
    return sent;
}

}  // namespace touchable
