#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace touchable {

/// Geometry of the Novint Falcon, as its owners have measured it (libnifalcon, after Stamper's thesis, 1997):
/// three arms around an axis, which a motor each turns in a plane through (about) the axis, and from the end
/// of each a parallelogram that carries the grip without turning it. Top, right and left arm, in this order.
///
/// Places are the grip's, in metres of the device: x right, y up, z towards the person, from the middle of
/// the reach, 0.125 m before the motors' plane.
inline constexpr double falcon_reach = 0.05;  ///< metres to each side; every place in this ball is reached
inline constexpr double falcon_edge = 0.075;  ///< metres; no grip gets as far from the middle
using FalconAngles =
    std::array<double, 3>;  ///< radians, 0: the arm points outward; grows as the grip is pulled

/// Of the arm, at an encoder's count: 320 slots of four counts on the motor's shaft, whose capstan of 14.25
/// mm turns the arm's drum of 110 mm; 35 degrees at 0.
double falcon_angle(std::int16_t count);

/// Closed form. Nothing where an arm does not reach.
std::optional<FalconAngles> falcon_angles(const glm::dvec3& place);

struct FalconPose {
    glm::dvec3 place{0.0};
    glm::dmat3 metres_per_radian{0.0};  ///< column: how the grip moves as that arm turns
};
/// By Newton's method from `start`, converged to far below a nanometre. Nothing where these angles belong to
/// no place within `falcon_edge`, as those of damaged packets.
std::optional<FalconPose> falcon_pose(const FalconAngles& angles, const glm::dvec3& start = glm::dvec3(0.0));

/// Largest motor word that is sent. The public driver's description has it as the cap; what a motor bears at
/// most is not published.
inline constexpr int falcon_largest_word = 4096;
/// Motor words whose torques exert that force, N. Too large ones are made smaller together, so the direction
/// stays. The unit of words is not published: as with the public driver, one is -0.1 mN m of the arm's
/// torque.
std::array<std::int16_t, 3> falcon_motor_words(const FalconPose& pose, const glm::dvec3& newtons);

}  // namespace touchable
